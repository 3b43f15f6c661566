"""Experiments as files: what they sweep, the cases that come of it, how these are run, split, merged and tabled."""
