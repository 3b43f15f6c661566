"""Options that several tools have, their checks, and what a tool needs before it starts."""

import argparse
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from ..cases.study_command import PROJECT
from ..experiments.experiment_file import experiment_path, read_experiment
from ..program.cli import OneLineParser, Problem, check_data, check_positive, check_program
from ..program.release_build import add_build_option

EVERY_SCENE = "default: every scene of the data set with one muscle"
INTERLEAVED = "nightly"  # the experiment of tools/nightly and tools/compare
WITHOUT_PROGRAM = ("report_only", "merge", "append", "simulate", "write_only")  # options with which nothing is measured


class BuiltProgram(type(Path())):
    """The program of a preset, which is built where no other is named."""

    @property
    def preset(self) -> str:
        return self.parts[-3]


def built_program(preset: str) -> BuiltProgram:
    return BuiltProgram(PROJECT / "build" / preset / "bench" / "musclebench")


@dataclass(frozen=True)
class Needs:
    """What has to be there before a tool starts. Python's packages always."""

    preset: str = ""  # of the build; empty: none
    compiler: bool = False  # for builds of its own
    packages: tuple[str, ...] = ()  # of Debian, beside those of tools/packages.txt
    can_go_without: bool = False  # packages that can't be installed cost a part of what the tool makes


def needs_of(options) -> Needs:
    """The build where no program is named and one is asked."""
    program = getattr(options, "musclebench", None)
    is_asked = not any(getattr(options, name, None) for name in WITHOUT_PROGRAM)
    return Needs(program.preset) if is_asked and isinstance(program, BuiltProgram) else Needs()


def needs_with_module(options) -> Needs:
    """And Python's module of that build, which is made where pybind11 is."""
    return replace(needs, packages=("pybind11-dev",)) if (needs := needs_of(options)).preset else needs


def study_parser(name: str, description: str) -> OneLineParser:
    return OneLineParser(prog=f"tools/{name}", description=description,
                         formatter_class=argparse.RawDescriptionHelpFormatter)


def add_run_options(group, timeout: float | None, preset: str = "release", is_timed: bool = True) -> None:
    """`timeout`: None is the experiment's own. `is_timed`: times of the cases are used."""
    group.add_argument("--out", type=Path, metavar="DIR",
                       help="folder of results (default: reports/out/STUDY-synthetic, -lhdl or -SCENE; with --quick STUDY-quick-...)")
    group.add_argument("--timeout", type=float, default=timeout, metavar="SECONDS",
                       help=f"time limit of one case (default: {'the experiment' + chr(39) + 's' if timeout is None else f'{timeout:g} s'})")
    again = group.add_mutually_exclusive_group()
    again.add_argument("--force", action="store_true",
                       help="run complete cases again, and replace a study of other settings in the same folder")
    again.add_argument("--keep-cases", action="store_true",
                       help="keep complete cases that another program measured. Use it if you only added a backend; tables name "
                            "the programs (default: run such cases again)")
    group.add_argument("--musclebench", type=Path, default=built_program(preset), metavar="PROGRAM",
                       help=f"program to measure (default: the build of preset {preset})")
    if is_timed:
        add_build_option(group)


def add_structures_option(group) -> None:
    group.add_argument("--structures", type=Path, metavar="DIR",
                       help="keep built structures and their build times in this folder, which several experiments can share "
                            "(default: in --out, until all cases are complete)")


def add_frames_option(group) -> None:
    group.add_argument("--frames-limit", type=int, metavar="N",
                       help="take a quick look: the whole motion runs in N frames, so bones move faster (default: all frames of "
                            "the scene)")


def add_page_option(group) -> None:
    group.add_argument("--no-page", action="store_true", help="make no report.html, the page with charts and runs in 3D")


def add_jobs_option(group) -> None:
    group.add_argument("--jobs", type=int, metavar="N",
                       help="cases that run at the same time, each on its own core; 1 gives the quietest times (default: 2, or 1 on one core)")


def check_options(options, builder: str = "") -> None:
    """All numbers are above 0, and only memory may be without limit; files and folders that are named are there. `builder`: the
    tool that builds the program, which has to be there by now unless only a report of what is there is wanted."""
    check_data(getattr(options, "data", None))
    for option, value in vars(options).items():
        if option == "memory_gb" and value == math.inf:
            continue
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            check_positive(f"--{option.replace('_', '-')}", value)
    scenes = getattr(options, "scene", None) or []
    for scene in [scenes] if isinstance(scenes, str) else scenes:
        check_scene(scene)
    out = getattr(options, "out", None)
    if out is not None and out.exists() and not out.is_dir():
        raise Problem(f"--out {out}: is a file; name a folder")
    if builder and not any(getattr(options, name, None) for name in WITHOUT_PROGRAM):
        check_program(options.musclebench, f"tools/{builder}")


def check_interleaved(options) -> None:
    """Those of add_case_options among them."""
    check_options(options)
    read_experiment(experiment_path(options.experiment))


def check_scene(scene: str) -> None:
    """A name that is no file is one of the program's, which knows them."""
    if scene.endswith(".toml") and not Path(scene).is_file():
        raise Problem(f"--scene {scene}: no such file; check the path")


def add_shard_option(group) -> None:
    group.add_argument("--shard", type=shard, default=(1, 1), metavar="I/N",
                       help="run only the I-th of N parts, on equal machines with the same build; tools/experiment --merge joins the parts "
                            "(default: 1/1)")


def add_memory_option(group) -> None:
    group.add_argument("--memory-gb", type=float, metavar="GB",
                       help="memory limit of one case; inf means no limit (default: its share of 90 %% of the machine's memory)")


def shard(text: str) -> tuple[int, int]:
    number, _, count = text.partition("/")
    if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
        raise argparse.ArgumentTypeError(f"'{text}' is not like 2/3, the second of three parts")
    return int(number), int(count)


def add_case_options(group) -> None:
    """Of what is run interleaved."""
    group.add_argument("--experiment", metavar="NAME_OR_FILE", default=INTERLEAVED,
                       help=f"an experiment of bench/experiments, or a .toml file with cases of mode run (default: {INTERLEAVED}, a "
                            "small scene and a muscle of the synthetic hip)")
    group.add_argument("--repetitions", type=int, metavar="N",
                       help="processes for each case and program; times need 5 or more (default: the experiment's)")
    group.add_argument("--scene", action="append", metavar="SCENE",
                       help="a scene that `musclebench list` prints, or a .toml file; may be repeated (default: the experiment's)")
    group.add_argument("--backend", action="append", metavar="NAME", help="backend to run; may be repeated (default: the experiment's)")
    group.add_argument("--frames", type=int, metavar="N", help="frames of each run (default: the experiment's)")
    group.add_argument("--timeout", type=float, metavar="SECONDS", help="time limit of one process (default: the experiment's)")


@dataclass(frozen=True)
class Tool:
    """`check` raises Problem for what the options and the disk tell; what only the program knows, such as the names of
    backends, comes after the build."""

    parse: Callable
    check: Callable = check_options
    needs: Callable = needs_of
