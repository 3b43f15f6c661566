"""Reads the result folders of runs; statistics of their rows."""
