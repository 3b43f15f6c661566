"""What accuracy costs in time: tables and figures of a study's result folders."""

from .report import AccuracyReport, write_report

__all__ = ["AccuracyReport", "write_report"]
