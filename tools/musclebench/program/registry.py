"""What the program knows: backends with their parameters and studies, presets and scenes (`list --json`)."""

import json
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from .cli import Problem
from .fingerprint import write_whole

SCHEMA = 1
ANSWER_SECONDS = 300  # on a machine that is busy with something else
FILE_NAME = "registry.json"  # beside the results of a study, whose report is made without the program
SIZE_ROLES = ("resolution", "wanted_error")
OFF_WORDS = ("", "0", "off", "false")


@dataclass(frozen=True)
class Parameter:
    name: str
    kind: str = "text"  # flag, integer, number, choice, path, text
    unit: str = ""
    default: object = ""
    role: str = ""  # resolution, wanted_error, storage, clearance_cache
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class Backend:
    name: str
    label: str
    help: str = ""
    colour: str | None = None
    dash: str | None = None
    is_exact: bool = False  # what is left of its errors is rounding
    parameters: tuple[Parameter, ...] = ()
    study: dict = field(default_factory=dict, compare=False)  # what backends/NAME/study.toml holds
    index: int = 10_000  # in the program's order
    implementation: str = ""  # whose code it is

    @property
    def title(self) -> str:
        """What people call it, for pictures and pages; tables and commands have its name."""
        return self.study.get("title") or self.label.replace("_", " ")

    @property
    def is_control(self) -> bool:
        """The loop without collision."""
        return bool(self.study.get("control"))

    @property
    def is_slow(self) -> bool:
        """It goes through every triangle, so that its study asks it about few frames; all would take hours."""
        return "longest_stride" in self.study

    @property
    def is_external(self) -> bool:
        """Another project's library, measured beside ours."""
        return bool(self.study.get("external", False))

    @property
    def has_resolution(self) -> bool:
        """Its answers get better the finer it is; those of the others are right or wrong."""
        return any(parameter.role in SIZE_ROLES for parameter in self.parameters)

    @property
    def series(self) -> list[dict]:
        """Of its study, with the values that all of them share."""
        return [self.study.get("defaults", {}) | series for series in self.study.get("series", [])]

    @property
    def has_many_choices(self) -> bool:
        """So many points without a resolution that figures number them and a table compares them with the default."""
        return not self.has_resolution and sum("sweep" not in series for series in self.series) > 2

    def parameter(self, name: str) -> Parameter:
        """One that the program does not list has no default."""
        return next((one for one in self.parameters if one.name == name), Parameter(name))

    def of_role(self, role: str) -> Parameter | None:
        return next((one for one in self.parameters if one.role == role), None)

    def uses_cache(self, parameters: dict) -> bool:
        """Whether the clearance cache is on: nodes that are known to be free are not asked about."""
        cache = self.of_role("clearance_cache")
        if cache is None or not self.matters(cache.name, parameters):
            return False
        return str(parameters.get(cache.name, cache.default)).lower() not in OFF_WORDS

    def matters(self, name: str, parameters: Mapping) -> bool:
        """Whether a parameter counts beside these; those of the study's `[[matters]]` count only where others have certain values."""
        def resolved(key: str) -> str:
            return plain_value(parameters.get(key, self.parameter(key).default))

        return all(resolved(key) in {plain_value(one) for one in (values if isinstance(values, list) else [values])}
                   for rule in self.study.get("matters", []) if rule["parameter"] == name
                   for key, values in rule["where"].items())


def plain_value(value) -> str:
    """The same text for what was asked for and what the program resolved it to."""
    if isinstance(value, bool):
        return str(value).lower()
    try:
        return f"{float(value):.12g}"
    except (TypeError, ValueError):
        return str(value)


@dataclass(frozen=True)
class SceneEntry:
    name: str
    title: str = ""
    muscles: tuple[str, ...] = ()
    bones: tuple[str, ...] = ()


@dataclass(frozen=True)
class Registry:
    backends: tuple[Backend, ...]
    scenes: tuple[SceneEntry, ...] = ()
    presets: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()  # in the program's order
    effect_helps: tuple[tuple[str, str], ...] = ()  # (name, what it does)
    effect_colours: tuple[tuple[str, str], ...] = ()  # (name, colour in figures)
    text: str = field(default="", compare=False)  # as the program printed it
    most_splits: int = 4  # of the triangles of a mesh

    @property
    def names(self) -> list[str]:
        """Of the backends, in the program's order."""
        return [backend.name for backend in self.backends]

    def backend(self, name: str) -> Backend:
        """One that is not built here is known by its name only."""
        return next((one for one in self.backends if one.name == name), Backend(name, name))

    def has(self, name: str) -> bool:
        return name in self.names

    @property
    def control(self) -> Backend | None:
        return next((backend for backend in self.backends if backend.is_control), None)

    @property
    def unit_of_price(self) -> tuple[Backend, dict] | None:
        """The configuration that times are divided by: backend and parameters."""
        for backend in self.backends:
            parameters = backend.study.get("advise", {}).get("unit_of_price")
            if parameters is not None:
                return backend, parameters
        return None


def whose(implementations: dict[str, str]) -> str:
    """Short sentences for below a table: by backend, whose code it is; empty where nobody told."""
    backends_of: dict[str, list[str]] = {}
    for backend, implementation in implementations.items():
        if implementation:
            backends_of.setdefault(implementation, []).append(backend)
    told = " ".join(f"{', '.join(backends)}: {implementation}." for implementation, backends in backends_of.items())
    return f"Whose code? {told}" if told else ""


def read_registry(program: Path) -> Registry:
    """Asks the program."""
    try:
        done = subprocess.run([str(program), "list", "--json"], capture_output=True, text=True, check=False,
                              timeout=ANSWER_SECONDS)
    except (OSError, subprocess.TimeoutExpired) as problem:
        raise Problem(f"{program}: 'list --json' does not answer ({problem})") from None
    if done.returncode != 0:
        raise Problem(f"{program}: 'list --json' ended with exit code {done.returncode}; is it of this project?")
    return parse_registry(done.stdout, str(program))


def saved_registry(out_dir: Path) -> Registry:
    """As a study noted it beside its results."""
    path = out_dir / FILE_NAME
    try:
        return parse_registry(path.read_text(), str(path))
    except OSError as problem:
        raise Problem(f"{path}: can't be read ({problem.strerror}); run the study again, which writes it") from None


def save_registry(registry: Registry, out_dir: Path) -> None:
    write_whole(out_dir / FILE_NAME, registry.text)


def parse_registry(text: str, source: str) -> Registry:
    """`source`: for messages."""
    try:
        told = json.loads(text)
        if told["schema"] != SCHEMA:
            raise Problem(f"{source}: lists its backends by schema {told['schema']}, these tools read {SCHEMA}; "
                          "use the tools and the program of one commit")
        backends = tuple(_backend(one, index) for index, one in enumerate(told["backends"]))
        scenes = tuple(SceneEntry(one["name"], one.get("title", ""), tuple(one.get("muscles", [])),
                                  tuple(one.get("bones", [])))
                       for one in told["scenes"])
        presets = tuple(one["name"] for one in told["presets"])
        effects = tuple(one["name"] for one in told.get("effects", []))
        effect_helps = tuple((one["name"], one["help"]) for one in told.get("effects", []) if one.get("help"))
        effect_colours = tuple((one["name"], one["colour"]) for one in told.get("effects", []) if one.get("colour"))
        most_splits = min((int(one["maximum"]) for one in told.get("meshes", [])), default=Registry.most_splits)
    except (ValueError, KeyError, TypeError) as problem:
        raise Problem(f"{source}: not what 'musclebench list --json' prints ({problem!r})") from None
    registry = Registry(backends, scenes, presets, effects, effect_helps, effect_colours, text, most_splits)
    _check_studies(registry, source)
    return registry


def _backend(told: dict, index: int) -> Backend:
    return Backend(told["name"], told.get("label") or told["name"], told.get("help", ""), told.get("colour"),
                   told.get("dash"), bool(told["exact"]), tuple(_parameter(one) for one in told["parameters"]),
                   told.get("study") or {}, index, told.get("implementation") or "")


def _parameter(told: dict) -> Parameter:
    return Parameter(told["name"], told["kind"], told.get("unit", ""), told["default"], told.get("role", ""),
                     tuple(told.get("choices") or ()))


def _check_studies(registry: Registry, source: str) -> None:
    for backend in registry.backends:
        known = {parameter.name for parameter in backend.parameters}
        for number, series in enumerate(backend.series, 1):
            sweep = series.get("sweep", {})
            if len(sweep) > 1:
                raise Problem(f"{source}: study of {backend.name}, series {number}: sweeps {', '.join(sweep)}; only "
                              "one parameter can be swept, put the others into series of their own")
            unknown = [key for key in (*sweep, *series.get("fixed", {})) if key not in known]
            if unknown:
                raise Problem(f"{source}: study of {backend.name}, series {number}: '{unknown[0]}' is not a parameter; "
                              f"there are: {', '.join(sorted(known)) or 'none'}")
