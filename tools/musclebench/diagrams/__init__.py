"""Schematic drawings of pages: what a word means, how a part works. They show no measured data."""
