#!/usr/bin/python3
"""Makes the board of bundles. Options: musclebench/options/board.py."""

import json
import sys
from pathlib import Path

from musclebench.board.bundle import Bundle
from musclebench.board.hard_cases import HardCase, hard_cases
from musclebench.board.made import bundle_of
from musclebench.board.reading import read_bundle
from musclebench.board.recompute import Limits, recompute
from musclebench.board.site import write_site
from musclebench.board.standing import REFUTED, machines_of
from musclebench.board.summary import as_summary
from musclebench.options.board import check, parse_arguments
from musclebench.program.cli import Problem, run_command
from musclebench.program.registry import read_registry
from musclebench.publish.measured import SOURCE, Measured
from musclebench.results.run_folder import ResultProblem

ACCURACY, HARD, STUDY = "accuracy-", "hard-", "study.csv"
CODE_REFUTED = 3


def read_all(paths: list[Path]) -> tuple[list[Bundle], list[HardCase]]:
    bundles, hard = [], []
    for path in paths:
        for one in _inside(path):
            if one.name.startswith(HARD) and (one / "cells.csv").is_file():
                hard += hard_cases(one)
            elif one is path or one.suffix == ".zip" or one.name.startswith(ACCURACY):
                bundles.append(bundle_of(one) if one.is_dir() else read_bundle(one))
    return bundles, hard


def _inside(path: Path) -> list[Path]:
    """Published studies and bundles of a folder that is no study itself; it may have none."""
    if not path.is_dir() or (path / SOURCE).is_file() or (path / STUDY).is_file():
        return [path]
    return [path / study for study in Measured(path).studies] + sorted(path.glob("*.zip"))


def say(text: str) -> None:
    print(f"board: {text}", file=sys.stderr, flush=True)


def make(options) -> int:
    check(options)
    (bundles, hard), (recomputed, _) = read_all(options.bundles), read_all(options.recomputed)
    if not bundles:
        raise Problem(f"{options.bundles[0]}: holds no study of accuracy; tools/accuracy measures one")
    asked = bundles
    answers, commit = [bundle.rows for bundle in recomputed], recomputed[0].header["commit"] if recomputed else ""
    if options.recompute is not None:
        asked = read_all(options.recompute)[0] or bundles
        registry = read_registry(options.musclebench)
        commit = json.loads(registry.text)["git"]
        answers.append(recompute(asked, options.musclebench, registry, options.data, Limits(options.longest, 60 * options.within), say))
    rows = write_site(bundles, hard, options.out, answers, commit)
    if options.summary:
        with options.summary.open("a", encoding="utf-8") as file:
            file.write(as_summary(rows, [name for bundle, name in zip(bundles, machines_of(bundles)) if bundle.header in [one.header for one in asked]]))
    counts = ", ".join(f"{count} {name}" for name, count in rows["standing"].value_counts().items())
    print(f"{options.out / 'index.html'}: {len(rows)} settings of {rows['backend'].nunique()} backends on {rows['machine'].nunique()} "
          f"machine{'s' if rows['machine'].nunique() > 1 else ''}: {counts}; {(rows['why_not'] != '').sum()} are shown and can't win")
    refuted = rows[rows["standing"] == REFUTED]
    for row in refuted.to_dict("records"):
        print(f"refuted: {row['configuration']} on {row['scene']}, of {row['title']}: {row['refutation']}", file=sys.stderr)
    return CODE_REFUTED if len(refuted) else 0


def main(arguments=None) -> int:
    return run_command("board", lambda: make(parse_arguments(arguments)), "the board is as it was", ResultProblem)


if __name__ == "__main__":
    sys.exit(main())
