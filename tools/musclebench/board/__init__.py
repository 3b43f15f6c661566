"""The board: what others measured, in bundles that anyone can check, and a site that ranks it."""
