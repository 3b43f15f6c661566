"""The configurations that studies sweep, as the backends' study.toml tell them, and what each may cost.

Times are guesses for a muscle of 6,931 nodes between two bones on one thread of a 2.5 GHz core. They choose strides and
repetitions, deal the parts of a split study, and feed the progress bar, which corrects them.
"""

from dataclasses import dataclass

from ..program.registry import Backend, Registry

LONGEST_STRIDE = 16  # 20 of the paper's frames, 2 of them for warming up: fewer don't tell a median
PROBE_BAND_MM = 2.0  # where contacts are


@dataclass(frozen=True)
class Configuration:
    backend: str
    parameters: tuple[tuple[str, object], ...] = ()
    threads: int = 1
    step_ms: float = 0.0
    build_seconds: float = 0.0
    stored_bytes: float = 0.0
    storage: str = ""  # the parameter that says where structures are kept; empty: it stores none
    in_quick: bool = True
    replays: bool = True
    drives: bool = True
    drives_quick: bool = True
    is_probed: bool = False
    probe_band_mm: float = PROBE_BAND_MM
    has_cache: bool = False  # caches are used up by motion: they are worth nothing where steps are left out
    longest_stride: int = LONGEST_STRIDE
    is_exact: bool = False  # what is left of its errors is rounding
    is_slow: bool = False  # its time grows with the bones' triangles
    named: str = ""  # by its backend's study; empty: by what it is

    @property
    def label(self) -> str:
        """Unique, and fit for a folder's name: a backend, or a backend and its choices: NAME-cells=64,clearance_cache=off."""
        if self.named:
            return self.named
        words = [f"{key}={value}" for key, value in self.parameters]
        words += [f"threads={self.threads}"] if self.threads > 1 else []
        return "-".join([self.backend, *([",".join(words)] if words else [])])

    @property
    def stores(self) -> bool:
        return bool(self.storage)


def configurations(registry: Registry) -> list[Configuration]:
    """Of all backends, in their order; one without a study takes part with its defaults."""
    return [one for backend in registry.backends for series in backend.series or [{}]
            for one in _of_series(backend, series)]


def raced(registry: Registry) -> list[Configuration]:
    """What the backends' studies race against each other."""
    return [_raced(backend, race) for backend in registry.backends for race in backend.study.get("race", [])]


def _raced(backend: Backend, race: dict) -> Configuration:
    storage, parameters = backend.of_role("storage"), race.get("parameters", {})
    return Configuration(
        backend.name, tuple(parameters.items()), step_ms=race.get("step_ms", 0.1), named=race["label"],
        storage=storage.name if storage and race.get("stores", False) else "", has_cache=backend.uses_cache(parameters),
        is_exact=backend.is_exact, is_slow=backend.is_slow)


def _of_series(backend: Backend, series: dict) -> list[Configuration]:
    ((swept, values),) = series.get("sweep", {"": [None]}).items()
    return [_configuration(backend, series, swept, value, index) for index, value in enumerate(values)]


def _configuration(backend: Backend, series: dict, swept: str, value, index: int) -> Configuration:
    declared = [parameter.name for parameter in backend.parameters]
    fixed = sorted(series.get("fixed", {}).items(), key=lambda item: declared.index(item[0]))
    parameters = ({swept: value} if swept else {}) | {key: _as_option(one) for key, one in fixed}
    quick, storage = series.get("quick", True), backend.of_role("storage")
    return Configuration(
        backend.name, tuple(parameters.items()), series.get("threads", 1), _at(series.get("step_ms", 0.1), index),
        _at(series.get("build_seconds", 0.0), index), _at(series.get("stored_bytes", 0.0), index),
        storage.name if storage and series.get("stores", False) else "",
        value in quick if isinstance(quick, list) else quick, series.get("replays", True), series.get("drives", True),
        series.get("drives_quick", series.get("drives", True)), series.get("probed", False),
        backend.study.get("probe_band_mm", PROBE_BAND_MM), backend.uses_cache(parameters),
        backend.study.get("longest_stride", LONGEST_STRIDE), backend.is_exact, backend.is_slow)


def _as_option(value):
    return str(value).lower() if isinstance(value, bool) else value


def _at(guess, index: int) -> float:
    """A guess is one number for all, or a list with one for each swept value."""
    return float(guess[index] if isinstance(guess, list) else guess)
