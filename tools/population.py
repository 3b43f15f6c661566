#!/usr/bin/python3
"""Makes members of a population, runs each with each setting, and says which hold. Options: musclebench/options/population.py."""

import argparse
import hashlib
import json
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from musclebench.cases.study_command import PROJECT, end, folders_of, require_results
from musclebench.experiments.command import chosen, print_plan
from musclebench.experiments.experiment_file import of_project
from musclebench.experiments.running import Sweep, limits_of, sweep_of
from musclebench.experiments.swept_case import SweptCase
from musclebench.experiments.swept_experiment import RESULT_DIRS
from musclebench.options.population import TOOL, parse_arguments
from musclebench.pictures.in_display import draw_in_display
from musclebench.population.base_scene import BaseScene, read_base_scene
from musclebench.population.members import ABOUT, Family, words_of
from musclebench.population.report import (
    Endings, Ending, answer, best_setting, broken_table, endings_of, members_table, settings_table,
)
from musclebench.population.running import MEMBERS, MemberScenes, is_told, survey_members, with_settings
from musclebench.population.shapes import drawn_amounts
from musclebench.population.toml_text import toml_text
from musclebench.program.cli import Problem, run_command
from musclebench.program.fingerprint import status_when_sealed, write_whole
from musclebench.program.native_module import add_native_module
from musclebench.program.optional_packages import require
from musclebench.program.out_folder import claimed_by_command
from musclebench.program.registry import read_registry
from musclebench.program.talker import Talker
from musclebench.results.run_folder import ResultProblem, read_run
from musclebench.tables.table_formats import as_text, write_table

TOLD = "population.json"
PICTURES = "broken"
MOST_PICTURES = 12
PICTURE_SECONDS = 900


def digest_of(base: BaseScene) -> str:
    """Of its tables and shapes."""
    found = hashlib.sha256(toml_text(base.tables).encode())
    for points in [*(part for one in [*base.bones.values(), *base.muscles.values()] for part in (one.vertices, one.triangles)), *base.outlines]:
        found.update(points.tobytes())
    for lines in base.fibres.values():
        found.update(b"".join(line.tobytes() for line in lines))
    return found.hexdigest()


def claim(options, base: BaseScene) -> None:
    """The folder is of this population from here on, or it is refused."""
    now = {"scene_sha256": digest_of(base), "shapes": [shape.words for shape in options.shape], "seed": options.seed}
    path = options.out / TOLD
    try:
        before = json.loads(path.read_text(encoding="utf-8")).get("of")
    except (OSError, ValueError):
        before = None
    if before is None and (options.out / MEMBERS).is_dir():
        raise Problem(f"{options.out}: has a folder {MEMBERS} of something else; choose another --out")
    if before is not None and before != now:
        names = {"scene_sha256": "another scene", "shapes": "other shapes", "seed": "another seed"}
        if not options.force:
            differ = ", ".join(words for key, words in names.items() if before.get(key) != now[key])
            raise Problem(f"{options.out}: holds a population of {differ}; choose another --out, or replace it with --force")
        for about in (options.out / MEMBERS).glob(f"*/{ABOUT}"):
            shutil.rmtree(about.parent)
    told = {"scene": options.scene, "of": now}
    write_whole(path, json.dumps(told if before != now else json.loads(path.read_text(encoding="utf-8")), indent=1) + "\n")


def make_members(options, base: BaseScene, numbers: list[int], say: Talker) -> dict[int, Path]:
    """{number: scene file}. Those that are there stay as they are."""
    say("fitting joints")
    family = Family(base, options.shape, options.seed)
    print("\n".join(words_of(family)), flush=True)
    files = {}
    for place, number in enumerate(numbers, start=1):
        folder = options.out / MEMBERS / f"{base.name}-m{number:04d}"
        if not (folder / ABOUT).is_file():
            if folder.exists():
                raise Problem(f"{folder}: is none of this tool's; remove it")
            part = folder.with_name(f".{folder.name}")  # a member is there whole or not at all
            shutil.rmtree(part, ignore_errors=True)
            family.member(number, part, folder.name)
            part.rename(folder)
        files[number] = folder / f"{folder.name}.toml"
        if is_told(place, len(numbers)):
            say(f"{place} of {len(numbers)} members made")
    return files


def sweep(options, scenes: MemberScenes) -> Sweep:
    registry = read_registry(options.musclebench)
    file = with_settings(of_project("population"), options, registry)
    asked = argparse.Namespace(**vars(options) | {"scene": None, "muscle": None})
    options.jobs, options.timeout = options.jobs or file.jobs, options.timeout or file.timeout_s
    return sweep_of(file, asked, registry, folders_of(options, "population"), scenes=scenes)


def cases_of(found: Sweep) -> list[SweptCase]:
    return [case for case in found.cases if isinstance(case, SweptCase)]


def endings(found: Sweep, scenes: MemberScenes, ran: list[SweptCase]) -> Endings:
    """`ran`: in this call; what an earlier one left counts only where it is of just these cases."""
    done = found.done(*(group.name for group in found.file.groups))
    runs = {case: read_run(folder) for case, folder in done.items()}
    experiment = found.experiment
    records = {case: experiment.run_record(case) for case in cases_of(found) if case not in runs
               and (case in ran or status_when_sealed(experiment.folder(case), experiment.print_of(case)))}
    return endings_of(cases_of(found), runs, records, scenes.numbers, scenes.refused)


def commands_of(found: Sweep, scenes: MemberScenes) -> dict[tuple[str, int], list[str]]:
    """What runs a case again, by setting and member."""
    return {(case.configuration.label, scenes.numbers[case.scene.name]): [str(found.experiment.binary), *case.arguments(found.experiment.folders)]
            for case in cases_of(found)}


def run_all(found: Sweep, scenes: MemberScenes, cases: list[SweptCase], options) -> list[str]:
    """A line for each without a result. The scene itself goes first: what it can't be run with, no member can."""
    limits = limits_of(options)
    first = [case for case in cases if scenes.numbers[case.scene.name] == 0]
    if first and len(first) < len(cases):
        found.run(first, limits)
        for case in first:
            record = found.experiment.run_record(case)
            if record.get("status") == "failed":
                raise Problem(f"{case.configuration.label}: {record.get('status_detail')}; no member was run")
    return found.run(cases, limits)


def draw(told: Endings, commands: dict[tuple[str, int], list[str]], out: Path, say: Talker) -> dict[tuple[str, int], Path]:
    """Runs what did not hold again, for its shape at rest and where it was worst; a picture each, of the first few."""
    broken = [(setting, number, one) for setting, by_member in told.items() for number, one in sorted(by_member.items())
              if number > 0 and one.run is not None and not one.holds]
    folder, names = out / PICTURES, {}
    for setting, number, one in broken[:MOST_PICTURES]:
        say(f"running member {number} with {setting} again, for its picture")
        name = f"m{number:04d}-{setting}"
        if shape_again(commands[setting, number], one, folder / "raw" / name):
            names[setting, number] = name
    if not names:
        return {}
    try:
        files = draw_in_display("population", folder, list(names.values()))
    except (Problem, OSError) as problem:
        print(f"population: no pictures: {problem}", file=sys.stderr)
        return {}
    by_name = {path.stem: path for path in files}
    return {key: by_name[name] for key, name in names.items() if name in by_name}


def shape_again(command: list[str], one: Ending, folder: Path) -> bool:
    assert one.run is not None
    last = int(one.run.record.get("frames") or 0)
    worst = one.worst_frame if one.worst_frame is not None else last
    moments = sorted({0, min(worst, last), last})
    try:
        subprocess.run([*command, "--snapshots", ",".join(map(str, moments)), "--out", str(folder)], capture_output=True, check=False, timeout=PICTURE_SECONDS)
    except subprocess.TimeoutExpired:
        return False
    return (folder / "run.json").is_file()


def report(options, found: Sweep, scenes: MemberScenes, ran: list[SweptCase], problems: list[str], say: Talker) -> int:
    told = endings(found, scenes, ran)
    amounts = {number: drawn_amounts(options.shape, number, options.seed) if number else [] for by_member in told.values() for number in by_member}
    settings = settings_table(told, options.scene)
    commands = commands_of(found, scenes)
    pictures = {} if options.no_pictures or options.report_only else draw(told, commands, options.out, say)
    spelled = {key: shlex.join(words) for key, words in commands.items()}
    tables = [settings, members_table(told, options.shape, amounts), broken_table(told, spelled, pictures)]
    words = answer(settings, told, options.hold)
    if left := sum(len(scenes.scenes) + len(scenes.refused) - len(by_member) for by_member in told.values()):
        words += f" {left} runs have no result, and do not count."
    files = [path for table in tables for path in write_table(table, options.out)]
    best = best_setting(settings, options.hold)
    plan = json.loads((options.out / TOLD).read_text(encoding="utf-8")) | {
        "hold_percent": options.hold, "setting": None if best is None else best["setting"], "answer": words,
        "refused": {str(number): why for number, why in scenes.refused.items()}}
    write_whole(options.out / TOLD, json.dumps(plan, indent=1) + "\n")
    print(f"\n{as_text(settings)}\n\n{words}")
    return max(end("population", [*files, *pictures.values(), options.out / TOLD], problems), 0 if best is not None else 1)


def tell(found: Sweep, scenes: MemberScenes, ran: list[SweptCase]) -> int:
    """Of --only: how each ended; the tables stay those of all members."""
    lines = [(setting, number, one) for setting, by_member in endings(found, scenes, ran).items() for number, one in sorted(by_member.items())]
    for setting, number, one in lines:
        print(f"member {number} with {setting}: {one.status}{f': {one.detail}' if one.detail else ''}")
    return 0 if all(one.holds for _, _, one in lines) else 1


def make(options) -> int:
    TOOL.check(options)
    require("vtk")
    add_native_module(options.musclebench)
    name = Path(options.scene).stem if options.scene.endswith(".toml") else options.scene.replace("/", "-")
    options.out = (options.out or PROJECT / "reports" / "out" / f"population-{name}").absolute()
    say = Talker("population")
    if options.report_only:
        require_results(options.out)
    say("reading the scene")
    base = read_base_scene(options.scene, options.musclebench, options.data)
    numbers = options.only or list(range(options.members + 1))
    with claimed_by_command(options.out, *RESULT_DIRS):
        claim(options, base)
        files = make_members(options, base, numbers, say)
        if options.make_only:
            print(f"{len(files)} members in {options.out / MEMBERS}, such as {files[numbers[-1]]}")
            return 0
        scenes = survey_members(files, options, read_registry(options.musclebench), folders_of(options, "population"), say)
        for number, why in scenes.refused.items():
            print(f"population: member {number} is refused: {why}", file=sys.stderr)
        found = sweep(options, scenes)
        cases = chosen(found, options.shard)
        if options.dry_run:
            print_plan(cases, found, len(limits_of(options).cores))
            return 0
        ran = [] if options.report_only else cases
        problems = run_all(found, scenes, cases, options) if ran else []
        if options.shard != (1, 1):
            print(f"This is part {options.shard[0]} of {options.shard[1]}. `tools/experiment population --merge` joins the parts; the same command with "
                  "--report-only then writes the tables")
            return 1 if problems else 0
        if options.only:
            return max(tell(found, scenes, ran), 1 if problems else 0)
        return report(options, found, scenes, ran, problems, say)


def main(arguments=None) -> int:
    return run_command("population", lambda: make(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
