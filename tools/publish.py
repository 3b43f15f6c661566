#!/usr/bin/python3
"""Runs every study and writes what pages quote of it. Options: musclebench/options/publish.py."""

import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from musclebench.cases.progress import duration
from musclebench.options.publish import check, parse_arguments
from musclebench.program.cli import Problem, check_program, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.publish.measured import Measured, adopt
from musclebench.publish.pages import pages_of, pictures_in, written
from musclebench.publish.published_tables import TABLES
from musclebench.publish.quoted import unmarked

TOOLS = Path(__file__).resolve().parent
PROJECT = TOOLS.parent
SEVERAL_MUSCLES = "hip"  # the scene of each data set whose muscles touch
SMOOTH_SCENES = ("iliacus", "gluteus_maximus")  # one that folds and one that doesn't
MADE_BY_CODE = {"hard"}  # studies whose scenes belong to no anatomy
REAL_ONLY = {"moment-arms"}  # studies beside which nothing stands for the synthetic hip


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
        return [sys.executable, str(TOOLS / f"{self.kind.replace('-', '_')}.py"), "--musclebench", str(program), "--out", str(out_dir),
                *(("--data", str(self.data_dir.resolve())) if self.data_dir else ()),
                *self._scene_arguments, *self.arguments]


def steps_of(options) -> list[Step]:
    data_sets = ["synthetic", *(["lhdl"] if options.data else [])]
    wanted = options.only or list(TABLES)
    steps = [Step(kind, name, _arguments(kind, name, options), options.data if name == "lhdl" else None, scene)
             for kind in TABLES if kind in wanted
             for name in (data_sets[:1] if kind in MADE_BY_CODE else data_sets[1:] if kind in REAL_ONLY else data_sets)
             for scene in ("", *([SEVERAL_MUSCLES] if kind == "paper" else []))]
    # Speed is about the muscle's own data where they are there: its targets were set on them.
    return [step for step in steps if step.kind != "speed" or step.data_set == data_sets[-1]]


def _arguments(kind: str, data_set: str, options) -> tuple[str, ...]:
    quick = {"paper": ("--frames-limit", "20"), "budget": ("--frames-limit", "20", "--finest", "2"), "hard": (),
             "moment-arms": ("--frames-limit", "12", "--passive-only")}.get(kind, ("--quick",))
    # Once each: the intervals come from blocks of frames and from samples. The dearest choices drive the smaller
    # muscles only. All of it has to fit into two hours.
    own = {"paper": ("--jobs", "1"),
           "speed": ("--repetitions", "1"),
           "effects": ("--jobs", "1"),
           "hard": ("--breaks-are-results",),
           "accuracy": ("--repetitions", "1", "--longest", "30",
                        *(() if data_set == "lhdl" else ("--muscle", "iliacus")))}.get(kind, ())
    if kind == "budget" and (options.quick or data_set != "lhdl"):
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


def publish(options) -> int:
    check(options)
    steps = [] if options.write_only else steps_of(options)
    if missing := set(options.only or ()) - {step.kind for step in steps} if not options.write_only else None:
        raise Problem(f"--only {', '.join(sorted(missing))}: measures real anatomy only; give its folder with --data")
    if options.dry_run:
        print_plan(steps, options)
        return 0
    adopted, problems = set(), []
    if steps:
        check_program(options.musclebench, "tools/publish")
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
