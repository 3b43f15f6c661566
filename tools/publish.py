#!/usr/bin/python3
"""Runs the paper's experiment, the accuracy study, the speed targets, the hard cases, the convergence of the substeps and
the study of effects on one commit and one machine, and writes every table, picture and quoted number of README and reports
from what they measured.

It goes on where it was stopped: complete cases are skipped by each study. A study that is complete is taken over into
reports/measured at once, with commit, machine and date; then the pages are written anew.
"""

import argparse
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from musclebench.cases.progress import duration
from musclebench.program.cli import OneLineParser, Problem, check_data, check_program, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.publish.measured import TABLES, Measured, adopt
from musclebench.publish.pages import pages_of, pictures_in, written
from musclebench.publish.quoted import unmarked

TOOLS = Path(__file__).resolve().parent
PROJECT = TOOLS.parent
PROGRAM = PROJECT / "build" / "bench" / "bench" / "musclebench"
SEVERAL_MUSCLES = "hip"  # the scene of each data set whose muscles touch
SMOOTH_SCENES = ("iliacus", "gluteus_maximus")  # one that folds and one that doesn't
MADE_BY_CODE = {"hard"}  # studies whose scenes belong to no anatomy


@dataclass(frozen=True)
class Step:
    """One study of one data set."""

    kind: str
    data_set: str
    arguments: tuple[str, ...]
    data_dir: Path | None = None
    scene: str = ""  # of the data set; empty: those that the study chooses

    @property
    def name(self) -> str:
        return "-".join(filter(None, (self.kind, self.data_set, self.scene)))

    @property
    def _scene_arguments(self) -> tuple[str, ...]:
        return ("--scene", f"{self.data_set}/{self.scene}") if self.scene else ()

    @property
    def shown(self) -> str:
        """The command as a page names it, without the paths of this machine."""
        words = (f"tools/{self.kind}", *(("--data", "DIR") if self.data_set == "lhdl" else ()), *self._scene_arguments,
                 *self.arguments)
        return " ".join(words)

    def command(self, program: Path, out_dir: Path) -> list[str]:
        return [sys.executable, str(TOOLS / f"{self.kind}.py"), "--musclebench", str(program), "--out", str(out_dir),
                *(("--data", str(self.data_dir.resolve())) if self.data_dir else ()),
                *self._scene_arguments, *self.arguments]


def parse_arguments(arguments):
    parser = OneLineParser(prog="tools/publish", description=__doc__,
                           formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, metavar="DIR", help="LHDL data folder: measure lhdl/* scenes, too")
    parser.add_argument("--quick", action="store_true",
                        help="a rehearsal: few frames and cases; pages go to the folder of the results, not into the "
                             "project")
    parser.add_argument("--only", action="append", choices=sorted(TABLES), metavar="STUDY",
                        help=f"one of {', '.join(sorted(TABLES))}; may be repeated (default: all)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: reports/out/publish[-quick]")
    parser.add_argument("--musclebench", type=Path, default=PROGRAM, metavar="PROGRAM",
                        help="the program to measure (default: that of the preset bench)")
    instead = parser.add_mutually_exclusive_group()
    instead.add_argument("--dry-run", action="store_true", help="print the commands and what they would write")
    instead.add_argument("--write-only", action="store_true", help="write the pages from reports/measured, run nothing")
    return parser.parse_args(arguments)


def steps_of(options) -> list[Step]:
    data_sets = ["synthetic", *(["lhdl"] if options.data else [])]
    wanted = options.only or list(TABLES)
    steps = [Step(kind, name, _arguments(kind, name, options), options.data if name == "lhdl" else None, scene)
             for kind in TABLES if kind in wanted for name in (data_sets[:1] if kind in MADE_BY_CODE else data_sets)
             for scene in ("", *([SEVERAL_MUSCLES] if kind == "paper" else []))]
    # Speed is about the muscle's own data where they are there: its targets were set on them.
    return [step for step in steps if step.kind != "speed" or step.data_set == data_sets[-1]]


def _arguments(kind: str, data_set: str, options) -> tuple[str, ...]:
    quick = {"paper": ("--frames-limit", "20"), "convergence": ("--substeps", "5,10"), "hard": ()}.get(kind, ("--quick",))
    # Once each: the intervals come from blocks of frames and from samples. The dearest choices drive the smaller
    # muscles only. All of it has to fit into two hours.
    own = {"paper": ("--jobs", "1"),
           "speed": ("--repetitions", "1"),
           "effects": ("--jobs", "1"),
           "hard": ("--breaks-are-results",),
           "accuracy": ("--repetitions", "1", "--longest", "30",
                        *(() if data_set == "lhdl" else ("--muscle", "iliacus")))}.get(kind, ())
    if kind == "convergence":
        names = SMOOTH_SCENES[:1] if options.quick else SMOOTH_SCENES
        own = tuple(word for name in names for word in ("--muscle", name))
    return (*own, *(quick if options.quick else ()))


def out_dir_of(options) -> Path:
    return (options.out or PROJECT / "reports" / "out" / f"publish{'-quick' if options.quick else ''}").absolute()


def print_plan(steps: list[Step], options) -> None:
    for step in steps:
        print(f"{step.name}: {' '.join(step.command(options.musclebench, out_dir_of(options) / step.name))}")
    print(f"writes {', '.join(str(path.relative_to(PROJECT)) for path in pages_of(PROJECT))}"
          f"{' to ' + str(out_dir_of(options) / 'pages') if options.quick else ''}")


def run_steps(steps: list[Step], options) -> tuple[set[str], list[str]]:
    """The studies that were taken over, all of one commit and machine; what went wrong, a line a study."""
    problems, adopted = [], {}
    publication = datetime.now(timezone.utc).isoformat(timespec="seconds")
    for number, step in enumerate(steps, 1):
        out_dir, started = out_dir_of(options) / step.name, time.monotonic()
        print(f"[{number}/{len(steps)}] {step.name}: {step.shown} -> {out_dir}", flush=True)
        command = step.command(options.musclebench, out_dir)
        code = subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode
        if code == 130:
            raise KeyboardInterrupt
        if code != 0:
            problems.append(f"{step.name} ended with {code}; run tools/publish again, complete cases are kept")
            continue
        try:
            source = adopt(step.name, out_dir, measured_folder(options) / step.name, step.shown, publication,
                           next(iter(adopted.values()), None))
        except Problem as problem:
            problems.append(str(problem))
            continue
        adopted[step.name] = source
        busy = f"; in {source.disturbed} runs the machine was busy" if source.disturbed else ""
        print(f"    done in {duration(time.monotonic() - started)}, commit {source.commit}{busy}", flush=True)
    return set(adopted), problems


def measured_folder(options) -> Path:
    return (out_dir_of(options) if options.quick else PROJECT / "reports") / "measured"


def write_pages(options, adopted: set[str]) -> list[str]:
    """Pages and the pictures of the studies that were taken over; prints what changed. A line for all that
    could not be written."""
    measured = Measured(measured_folder(options))
    if options.quick:  # what a rehearsal doesn't measure stays as it is in the project
        for study in Measured(PROJECT / "reports" / "measured").studies:
            if study not in measured.studies:
                shutil.copytree(PROJECT / "reports" / "measured" / study, measured.folder / study, dirs_exist_ok=True)
    changed, pictures, problems = [], 0, []
    for page in pages_of(PROJECT):
        old = page.read_text()
        new = written(old, measured, str(page.relative_to(PROJECT)), problems)
        target = out_dir_of(options) / "pages" / page.relative_to(PROJECT) if options.quick else page
        target.parent.mkdir(parents=True, exist_ok=True)
        if new != old or options.quick:
            write_whole(target, new)
        if new != old:
            changed.append(str(target))
        pictures += _copy_pictures(new, page, adopted, options)
        problems += [f"{page.relative_to(PROJECT)}:{line}: '{words}' is quoted outside of markers"
                     for line, words in unmarked(new)]
    print("\n".join(["Written:", *(f"  {name}" for name in changed)]) if changed else "No page changed.")
    print(f"{pictures} pictures copied.")
    return problems


def _copy_pictures(text: str, page: Path, fresh: set[str], options) -> int:
    count = 0
    for picture in pictures_in(text, page):
        source = out_dir_of(options) / picture.study / "figures" / f"{picture.figure}{picture.file.suffix}"
        if picture.study in fresh and source.is_file() and not options.quick:
            shutil.copyfile(source, picture.file)
            count += 1
    return count


def check_tree() -> None:
    """What is published has to be of a commit that others can get."""
    done = subprocess.run(["git", "-C", str(PROJECT), "status", "--porcelain", "--", ".", ":!reports", ":!README.md"],
                          capture_output=True, text=True, check=False)
    if done.returncode != 0 or done.stdout.strip():
        raise Problem("the working tree has changes that no commit holds; commit them first, or rehearse with --quick")


def publish(options) -> int:
    check_data(options.data)
    steps = [] if options.write_only else steps_of(options)
    if options.dry_run:
        print_plan(steps, options)
        return 0
    adopted, problems = set(), []
    if steps:
        check_program(options.musclebench, "tools/publish")
        if not options.quick:
            check_tree()
        adopted, problems = run_steps(steps, options)
    problems += write_pages(options, adopted)
    for problem in problems:
        print(f"publish: {problem}", file=sys.stderr)
    print("Published." if not problems else "Not all was published.")
    return 1 if problems else 0


def main(arguments=None) -> int:
    return run_command("publish", lambda: publish(parse_arguments(arguments)),
                       "complete cases are kept; run it again to go on")


if __name__ == "__main__":
    sys.exit(main())
