"""Figures drawn from numbers, with the captions that say what was run."""
