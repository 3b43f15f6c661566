"""The backends of the paper's experiment."""

from ..experiments.experiment_file import of_project


def paper_backends() -> list[str]:
    """In the order of its tables and figures."""
    return list(of_project("paper").groups[0].backends)
