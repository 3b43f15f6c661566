"""Runs the cases of the paper's experiment, one process a case, and keeps one folder a case."""
