"""The backends of the paper's experiment."""

from ..experiments.experiment_file import experiment_path, read_experiment

NAME = "paper"


def paper_backends() -> list[str]:
    """In the order of its tables and figures."""
    return list(read_experiment(experiment_path(NAME)).groups[0].backends)
