"""Experiment files: their keys, what each may hold, and the one line that says what is wrong with one."""

import difflib
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

from ..program.cli import Problem
from .toml_lines import key_lines, line_of

FOLDER = Path(__file__).resolve().parents[3] / "bench" / "experiments"
MODES = ("run", "replay", "probe", "hard", "kernels")
MOMENTS = ("rest", "half", "full", "middle", "end", "after_rest", "motion")
EFFECT_SETS = ("own", "all", "all-each", "own+each")
NAMED = "{scene}-{group}-{configuration}-r{repetition}"
NAMED_OF_MODE = {"kernels": "kernels-{group}-r{repetition}"}
ASKED = "asked"  # in place of scenes: those that the command line names and no other group has


@dataclass(frozen=True)
class CaseGroup:
    """One [[cases]]: what its lists hold is multiplied."""

    name: str
    mode: str = "run"
    named: str = NAMED  # folder of a case; placeholders are PLACEHOLDERS and the axes
    scenes: str | tuple[str, ...] = ""  # empty: those of the experiment
    preset: str = ""  # empty: that of the experiment
    file_presets: bool = False  # scene files keep their own
    one_scene: str | tuple[str, ...] = ()  # of its scenes: the largest, or the first of these that there is; empty: all
    together: bool = False  # what a round has of a scene is not shuffled among the rest
    stores: bool = False  # the first case of a scene and configuration builds structures, which the others load
    backends: str | tuple[str, ...] = "all"
    if_built: bool = False  # backends that the program lacks are left out
    configurations: str = "default"  # or the name that a study gives to a set of choices
    only: tuple[str, ...] = ()
    parameters: tuple[tuple[str, tuple], ...] = ()
    threads: tuple[int, ...] = (1,)
    repetitions: int = 0  # 0: those of the experiment
    fewer_repetitions: bool = False
    judged: str = "always"
    snapshots: tuple[str, ...] = ()
    frames: tuple[int, ...] = ()
    counted_frames: int = 0  # of a run more, whose instructions are counted where programs are compared
    effects: tuple[str, ...] = ()
    adds_effect: str = ""
    substeps: tuple[int, ...] = ()
    times_substeps: tuple[float, ...] = ()  # the scene's own, times these
    times_iterations: tuple[float, ...] = ()
    split_muscles: tuple[int, ...] = ()  # splits of triangles, more than the scene's own
    smooth_bones: tuple[int, ...] = ()
    work: float = 1.0  # of a step, in steps of the scene as it is: a guess, where meshes are finer
    rest_s: float = 0.0
    vary: tuple[tuple[str, tuple[tuple[str, tuple[str, ...]], ...]], ...] = ()
    options: tuple[str, ...] = ()
    stride: str | int = 1  # of replays; auto: a power of two that keeps to replay_s
    replay_s: float = 4.0
    band_mm: float = 10.0
    points: int = 100_000
    hard_cases: tuple[str, ...] = ()  # empty: all
    program: str = "musclebench_micro"  # of kernels, in the folder micro/ beside the program
    kernels: tuple[str, ...] = ()  # beside those that the backends' study.toml names for the group
    sizes: tuple[int, ...] = ()  # of kernels that have one; empty: all
    samples: int = 5  # of each kernel; 1: what does not vary
    sample_s: float = 0.2  # least time of each
    guessed_s: float = 60.0  # of all kernels of the group
    longest_s: float = 0.0  # 0: as long as it takes

    @property
    def axes(self) -> list[str]:
        """Names of what its points differ in beside scene, configuration and repetition."""
        told = {"effects": self.effects, "substeps": self.substeps or self.times_substeps, "frames": self.frames,
                "iterations": self.times_iterations, "split_muscles": self.split_muscles, "smooth_bones": self.smooth_bones}
        own = [name for name, values in told.items() if values]
        return own + (["case"] if self.mode == "hard" else []) + [key for key, _ in self.vary]

    def is_single(self, axis: str) -> bool:
        """Whether cases can't differ in it."""
        return axis in ("substeps", "frames") and len(getattr(self, axis)) == 1


@dataclass(frozen=True)
class ExperimentFile:
    path: Path
    title: str
    groups: tuple[CaseGroup, ...]
    scenes: str | tuple[str, ...] = "one_muscle"
    preset: str = ""
    repetitions: int = 1
    seed: int = 1
    timeout_s: float = 1800.0
    jobs: int = 2
    frames_limit: int = 0  # frames of a whole run; 0: as many as scene and preset have
    answers: tuple[str, ...] = ()  # statuses beside ok and suspect with which a case has ended well

    @property
    def name(self) -> str:
        return self.path.stem

    def with_groups(self, **changes) -> "ExperimentFile":
        """The same with these keys in every group that has something there already."""
        return replace(self, groups=tuple(
            replace(group, **{key: value for key, value in changes.items() if getattr(group, key)})
            for group in self.groups))

    def on(self, scenes: tuple[str, ...]) -> "ExperimentFile":
        """In place of its scenes. One with [[cases]] for what is asked runs nothing else: others keep of their own scenes
        those that are asked, and these take the rest."""
        if all(group.scenes != ASKED for group in self.groups):
            return replace(self, scenes=scenes)
        own = {scene for group in self.groups if group.scenes != ASKED for scene in group.scenes}
        kept = [tuple(scene for scene in scenes if (scene not in own if group.scenes == ASKED else scene in group.scenes))
                for group in self.groups]
        return replace(self, groups=tuple(replace(group, scenes=some) for group, some in zip(self.groups, kept) if some))


PLACEHOLDERS = ("scene", "group", "backend", "configuration", "repetition")


def experiment_path(wanted: str) -> Path:
    """A file, or the name of one of the project's."""
    path = Path(wanted)
    if path.suffix == ".toml":
        if not path.is_file():
            raise Problem(f"{wanted}: no such file; check the path")
        return path
    known = sorted(one.stem for one in FOLDER.glob("*.toml"))
    if wanted not in known:
        raise Problem(f"'{wanted}': no experiment of that name;{_nearest(wanted, known)} there are: {', '.join(known)}")
    return FOLDER / f"{wanted}.toml"


def of_project(name: str) -> ExperimentFile:
    return read_experiment(experiment_path(name))


def read_experiment(path: Path) -> ExperimentFile:
    """Raises Problem: file, line, key, cure."""
    try:
        text = path.read_text()
        told = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise Problem(f"{path}: not TOML: {problem}") from None
    except UnicodeDecodeError:
        raise Problem(f"{path}: not TOML: the file is no text; name a .toml file") from None
    return _Reader(path, key_lines(text)).experiment(told)


@dataclass
class _Reader:
    path: Path
    lines: dict[tuple, int] = field(repr=False)

    def experiment(self, told: dict) -> ExperimentFile:
        values = self._values(told, (), EXPERIMENT_KEYS)
        groups = values.pop("cases")
        if not groups:
            self._refuse((), "has no [[cases]]")
        names = [group["name"] for group in groups if isinstance(group, dict) and "name" in group]
        for index, group in enumerate(groups):
            if names.count(group.get("name")) > 1:
                self._refuse(("cases", index, "name"), f"'{group['name']}' is the name of two [[cases]]")
        return ExperimentFile(self.path, groups=tuple(self._group(one, i) for i, one in enumerate(groups)), **values)

    def _group(self, told: dict, index: int) -> CaseGroup:
        values = self._values(told, ("cases", index), GROUP_KEYS)
        group = CaseGroup(**{"named": NAMED_OF_MODE.get(values.get("mode", ""), NAMED)} | values)
        known = {*PLACEHOLDERS, *group.axes}
        for word in _placeholders(group.named):
            if word not in known:
                self._refuse(("cases", index, "named"),
                             f"'{{{word}}}' stands for nothing;{_nearest(word, known)} there are: {', '.join(sorted(known))}")
        left_out = [axis for axis in group.axes if f"{{{axis}}}" not in group.named and not group.is_single(axis)]
        if left_out:
            self._refuse(("cases", index, "named"), f"cases that differ in '{left_out[0]}' would have one name; put "
                                                    f"'{{{left_out[0]}}}' into it")
        return group

    def _values(self, told: dict, where: tuple, keys: dict[str, tuple[bool, Callable]]) -> dict:
        for key in told:
            if key not in keys:
                self._refuse((*where, key), f"unknown key;{_nearest(key, keys)} there are: {', '.join(keys)}")
        values = {}
        for key, (is_needed, check) in keys.items():
            if key in told:
                try:
                    values[key] = check(told[key])
                except ValueError as problem:
                    self._refuse((*where, key), str(problem))
            elif is_needed:
                self._refuse(where, f"key '{key}' is missing", named=False)
        return values

    def _refuse(self, where: tuple, words: str, named: bool = True) -> None:
        key = f"key '{where[-1]}': " if named and where and isinstance(where[-1], str) else ""
        raise Problem(f"{self.path}: line {line_of(self.lines, where)}: {key}{words}")


def _nearest(word: str, known) -> str:
    near = difflib.get_close_matches(str(word), list(known), 1, 0.5)
    return f" did you mean '{near[0]}'?" if near else ""


def _placeholders(template: str) -> list[str]:
    return [part.partition("}")[0] for part in template.split("{")[1:]]


def _text(value) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError(f"{value!r} is no text")
    return value


def _choice(*known: str) -> Callable:
    def check(value) -> str:
        if value not in known:
            raise ValueError(f"{value!r};{_nearest(value, known)} there are: {', '.join(known)}")
        return value
    return check


def _number(kind, least) -> Callable:
    words = "whole number" if kind is int else "number"

    def check(value):
        if isinstance(value, bool) or not isinstance(value, (int, kind)) or not least <= value < float("inf"):
            raise ValueError(f"{value!r} is no {words} of {least} or more")
        return kind(value)
    return check


def _list(check: Callable) -> Callable:
    def check_all(value) -> tuple:
        if not isinstance(value, list) or not value:
            raise ValueError(f"{value!r} is no list, or an empty one")
        return tuple(check(one) for one in value)
    return check_all


def _words(*known: str) -> Callable:
    """One of the known words, or a list of names."""
    def check(value):
        if isinstance(value, str):
            return _choice(*known)(value)
        return _list(_text)(value)
    return check


def _flag(value) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{value!r} is neither true nor false")
    return value


def _table(check: Callable) -> Callable:
    def check_all(value) -> tuple:
        if not isinstance(value, dict) or not value:
            raise ValueError(f"{value!r} is no table, or an empty one")
        return tuple((key, check(one)) for key, one in value.items())
    return check_all


def _values_of_parameter(value) -> tuple:
    return _list(_scalar)(value if isinstance(value, list) else [value])


def _scalar(value):
    if not isinstance(value, (str, int, float)):
        raise ValueError(f"{value!r} is neither text nor a number")
    return str(value).lower() if isinstance(value, bool) else value


def _words_or_none(value) -> tuple[str, ...]:
    return () if value == [] else _list(_text)(value)


def _stride(value):
    return value if value == "auto" else _number(int, 1)(value)


def _tables(value) -> list:
    if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
        raise ValueError("is written [[cases]], once for each group")
    return value


SCENE_SETS = ("one_muscle", "every_muscle")  # of a data set
# {key: (is needed, check)}
EXPERIMENT_KEYS: dict[str, tuple[bool, Callable]] = {
    "title": (True, _text), "scenes": (False, _words(*SCENE_SETS)), "preset": (False, _text), "repetitions": (False, _number(int, 1)),
    "seed": (False, _number(int, 0)), "timeout_s": (False, _number(float, 0.001)), "jobs": (False, _number(int, 1)),
    "frames_limit": (False, _number(int, 1)),
    "answers": (False, _list(_choice("diverged", "unsupported", "nondeterministic"))), "cases": (True, _tables),
}
GROUP_KEYS: dict[str, tuple[bool, Callable]] = {
    "name": (True, _text), "mode": (False, _choice(*MODES)), "named": (False, _text),
    "scenes": (False, _words(*SCENE_SETS, ASKED)), "preset": (False, _text), "file_presets": (False, _flag),
    "backends": (False, _words("all", "exact", "control", "fast", "slow", "external")),
    "if_built": (False, _flag), "configurations": (False, _text),
    "only": (False, _list(_choice("replays", "drives", "probed", "one_thread"))),
    "parameters": (False, _table(_values_of_parameter)), "threads": (False, _list(_number(int, 1))),
    "repetitions": (False, _number(int, 1)), "fewer_repetitions": (False, _flag),
    "judged": (False, _choice("always", "first", "never")), "snapshots": (False, _list(_choice(*MOMENTS))),
    "frames": (False, _list(_number(int, 1))),
    "counted_frames": (False, _number(int, 1)), "effects": (False, _list(_choice(*EFFECT_SETS))),
    "adds_effect": (False, _text), "substeps": (False, _list(_number(int, 1))),
    "times_substeps": (False, _list(_number(float, 0.001))), "times_iterations": (False, _list(_number(float, 0.001))),
    "split_muscles": (False, _list(_number(int, 0))), "smooth_bones": (False, _list(_number(int, 0))),
    "rest_s": (False, _number(float, 0)), "work": (False, _number(float, 0.001)),
    "vary": (False, _table(_table(_words_or_none))), "options": (False, _list(_text)), "stride": (False, _stride),
    "band_mm": (False, _number(float, 0.001)), "points": (False, _number(int, 1)), "replay_s": (False, _number(float, 0.001)),
    "longest_s": (False, _number(float, 0.001)), "hard_cases": (False, _list(_text)),
    "one_scene": (False, _words("largest")), "together": (False, _flag), "stores": (False, _flag),
    "program": (False, _text), "kernels": (False, _list(_text)), "sizes": (False, _list(_number(int, 1))),
    "samples": (False, _number(int, 1)), "sample_s": (False, _number(float, 0.001)),
    "guessed_s": (False, _number(float, 0.001)),
}
assert set(GROUP_KEYS) == {one.name for one in fields(CaseGroup)}
