"""The experiment of the paper: its cases and its published numbers."""
