"""Measures the bars of speed: coupled runs and kernels, and one table of what holds."""
