"""Runs experiments with the program musclebench and makes tables, figures and pictures of its result folders."""

from .program.optional_packages import stand_in_for_missing

stand_in_for_missing()
