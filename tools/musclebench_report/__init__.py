"""Reads finished runs and makes the tables, figures and pictures of the paper from them."""
