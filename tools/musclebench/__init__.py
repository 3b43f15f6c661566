"""Runs experiments with the program musclebench and makes tables, figures and pictures of its result folders."""
