"""What was measured night by night: the history, its change points, what is reported of them."""
