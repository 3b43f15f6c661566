#!/usr/bin/python3
"""Makes members of a population, runs each with each setting, and says which hold. Options: musclebench/options/population.py."""

import argparse
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
from musclebench.options.population import TOOL, parse_arguments
from musclebench.pictures.in_display import draw_in_display
from musclebench.population.base_scene import read_base_scene
from musclebench.population.members import Family, joint_words
from musclebench.population.report import (
    Endings, Ending, answer, best_setting, broken_table, endings_of, members_table, settings_table,
)
from musclebench.population.running import MEMBERS, MemberScenes, is_told, survey_members, with_settings
from musclebench.population.shapes import drawn_amounts
from musclebench.program.cli import Problem, run_command
from musclebench.program.fingerprint import write_whole
from musclebench.program.optional_packages import require
from musclebench.program.registry import read_registry
from musclebench.program.talker import Talker
from musclebench.results.run_folder import ResultProblem, read_run
from musclebench.tables.table_formats import as_text, write_table

TOLD = "population.json"
MOST_PICTURES = 12
PICTURE_SECONDS = 900


def make_members(options, out: Path, numbers: list[int], say: Talker) -> tuple[dict[int, Path], list[str]]:
    """{number: scene file}, and what is known of the joints."""
    say("reading the scene")
    base = read_base_scene(options.scene, options.musclebench, options.data)
    say("fitting joints")
    family = Family(base, options.shape, options.seed)
    files = {}
    for place, number in enumerate(numbers, start=1):
        folder = out / MEMBERS / f"{base.name}-m{number:0{len(str(options.members))}d}"
        shutil.rmtree(folder, ignore_errors=True)
        files[number] = family.member(number, folder).scene
        if is_told(place, len(numbers)):
            say(f"{place} of {len(numbers)} members made")
    return files, joint_words(family.joints)


def sweep(options, scenes: MemberScenes) -> Sweep:
    registry = read_registry(options.musclebench)
    file = with_settings(of_project("population"), options, registry)
    asked = argparse.Namespace(**vars(options) | {"scene": None, "muscle": None})
    options.jobs, options.timeout = options.jobs or file.jobs, options.timeout or file.timeout_s
    return sweep_of(file, asked, registry, folders_of(options, "population"), scenes=scenes)


def endings(found: Sweep, scenes: MemberScenes) -> Endings:
    cases = [case for case in found.cases if isinstance(case, SweptCase)]
    done = found.done(*(group.name for group in found.file.groups))
    runs = {case: read_run(folder) for case, folder in done.items()}
    records = {case: found.experiment.run_record(case) for case in cases if case not in runs}
    return endings_of(cases, runs, records, scenes.numbers, scenes.refused)


def commands_of(found: Sweep, scenes: MemberScenes) -> dict[tuple[str, int], list[str]]:
    """What runs a case again, by setting and member."""
    cases = [case for case in found.cases if isinstance(case, SweptCase)]
    return {(case.configuration.label, scenes.numbers[case.scene.name]): [str(found.experiment.binary), *case.arguments(found.experiment.folders)]
            for case in cases}


def draw(told: Endings, commands: dict[tuple[str, int], list[str]], out: Path, say: Talker) -> dict[tuple[str, int], Path]:
    """Runs what did not hold again, for its shape at rest and where it was worst; a picture each, of the first few."""
    broken = [(setting, number, one) for setting, by_member in told.items() for number, one in sorted(by_member.items())
              if number > 0 and one.run is not None and not one.holds]
    folder, names = out / "broken", {}
    shutil.rmtree(folder, ignore_errors=True)
    for setting, number, one in broken[:MOST_PICTURES]:
        say(f"running member {number} with {setting} again, for its picture")
        name = f"m{number}-{setting}"
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


def report(options, found: Sweep, scenes: MemberScenes, problems: list[str], say: Talker) -> int:
    out = found.experiment.folders.out_dir
    told = endings(found, scenes)
    amounts = {number: drawn_amounts(options.shape, number, options.seed) if number else [] for by_member in told.values() for number in by_member}
    settings = settings_table(told, options.scene)
    commands = commands_of(found, scenes)
    pictures = {} if options.no_pictures or options.report_only else draw(told, commands, out, say)
    spelled = {key: shlex.join(words) for key, words in commands.items()}
    tables = [settings, members_table(told, options.shape, amounts), broken_table(told, spelled, pictures)]
    words = answer(settings, told, options.hold)
    files = [path for table in tables for path in write_table(table, out)]
    best = best_setting(settings, options.hold)
    plan = {"scene": options.scene, "shapes": [shape.words for shape in options.shape], "seed": options.seed, "members": options.members,
            "hold_percent": options.hold, "setting": None if best is None else best["setting"], "answer": words,
            "refused": {str(number): why for number, why in scenes.refused.items()}}
    write_whole(out / TOLD, json.dumps(plan, indent=1) + "\n")
    print(f"\n{as_text(settings)}\n\n{words}")
    return max(end("population", [*files, *pictures.values(), out / TOLD], problems), 0 if best is not None else 1)


def make(options) -> int:
    TOOL.check(options)
    require("vtk")
    name = Path(options.scene).stem if options.scene.endswith(".toml") else options.scene.replace("/", "-")
    options.out = (options.out or PROJECT / "reports" / "out" / f"population-{name}").absolute()
    say = Talker("population")
    if options.report_only:
        require_results(options.out)
    numbers = options.only or list(range(options.members + 1))
    files, joints = make_members(options, options.out, numbers, say)
    for words in joints:
        print(words)
    if options.make_only:
        print(f"{len(files)} members in {options.out / MEMBERS}, such as {files[numbers[-1]]}")
        return 0
    scenes = survey_members(files, options, read_registry(options.musclebench), folders_of(options, "population"), say)
    for number, why in scenes.refused.items():
        print(f"population: member {number} is refused: {why}", file=sys.stderr)
    found = sweep(options, scenes)
    cases = chosen(found, options.shard)
    limits = limits_of(options)
    if options.dry_run:
        print_plan(cases, found, len(limits.cores))
        return 0
    problems = [] if options.report_only else found.run(cases, limits)
    if options.shard != (1, 1):
        print(f"This is part {options.shard[0]} of {options.shard[1]}: tools/experiment population --merge joins them, --report-only then writes the tables")
        return 1 if problems else 0
    return report(options, found, scenes, problems, say)


def main(arguments=None) -> int:
    return run_command("population", lambda: make(parse_arguments(arguments)),
                       "complete runs are kept, unfinished ones removed", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
