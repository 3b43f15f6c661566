"""Measures speed against the project's targets: coupled runs and kernels, and one table of what holds."""
