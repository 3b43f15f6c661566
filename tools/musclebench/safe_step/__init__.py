"""The largest step at which a run stays right, by backend, response and guard."""
