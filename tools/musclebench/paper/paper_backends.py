"""The backends of the paper's experiment, and what its tables call the runs."""

from collections.abc import Iterable

from ..accuracy.configurations import configuration
from ..experiments.experiment_file import of_project
from ..figures import looks
from ..results.run_folder import Run


def paper_backends() -> list[str]:
    """In the order of its tables and figures."""
    return list(of_project("paper").groups[0].backends)


def name_of(run: Run) -> str:
    """The backend's name; with choices that its study names together, these as well: `fcl as advised`."""
    about, case = looks.backend(run.backend), run.record["case"]
    if not about.study.get("named"):
        return run.backend
    chosen = configuration(about, case.get("parameters", {}), case.get("threads", 1)).named_set
    return f"{about.label} {chosen}" if chosen else run.backend


def in_paper_order(names: Iterable[str]) -> list[str]:
    """Without repetition. What a backend does with other choices follows it; the rest come last."""
    listed, names = paper_backends(), set(names)
    return sorted(names, key=lambda name: (listed.index(base) if (base := looks.base_of(name)) in listed else len(listed), name))


def starts_off_by_rounding(run: Run) -> bool:
    """Whether the run only tells what rounding does to the shape."""
    return run.record["case"].get("loop", {}).get("start_noise_m", 0) > 0
