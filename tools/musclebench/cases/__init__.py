"""Runs the cases of an experiment, one process a case, and keeps one folder a case."""
