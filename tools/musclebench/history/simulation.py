"""Nights that never were, drawn from recorded noise: how often an unchanged program alarms, and after how many nights a
slowdown is found."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ..comparison.metrics import METRICS
from ..comparison.result_set import ResultSet, Sample
from ..comparison.verdicts import PROGRAM_SIDES, compare
from ..results.run_folder import Run
from ..results.statistics import percentile
from .detection import new_ones, step_findings
from .history import Finding

RECORDED = Path(__file__).resolve().parent / "recorded_noise.csv"
MACHINE_SPREAD = 0.03  # of a night's machine, of all cases together: beyond what an hour's recording shows
REPETITIONS = 10
CASE_STRIDE = 7  # of the sorted cases, so that a few trials take quiet and noisy ones


@dataclass(frozen=True)
class Rates:
    trials: int
    nights: int
    false_alarms: int  # histories without a change in which something alarmed
    found_after: tuple[int, ...]  # nights after which the slowdown was found, of each trial that found it; 1: the same night
    wrong: int  # histories with a slowdown in which something else alarmed, too

    def found_within(self, nights: int) -> int:
        return sum(after <= nights for after in self.found_after)


def read_noise(path: Path = RECORDED) -> dict[tuple[str, str], np.ndarray]:
    """{(case, metric): values one after the other, over their median}"""
    rows = pd.read_csv(path, comment="#")
    metrics = [column for column in rows if column in METRICS]
    return {(case, metric): values for case, group in rows.groupby("case") for metric in metrics
            if len(values := group.sort_values("round")[metric].dropna().to_numpy()) >= REPETITIONS}


def drawn_nights(noise: dict, nights: int, random: np.random.Generator) -> pd.DataFrame:
    """Of each night the lower quartiles of REPETITIONS that were recorded one after the other, from the same moment for all
    cases."""
    rows = []
    for night in range(1, nights + 1):
        moment, machine = random.random(), np.exp(random.normal(0, MACHINE_SPREAD))
        for (case, metric), values in noise.items():
            first = int(moment * (len(values) - REPETITIONS + 1))
            rows.append({"night": night, "case": case, "metric": metric, "kind": METRICS[metric].kind, "unit": "ns",
                         "quartile": 1e5 * machine * percentile(values[first:first + REPETITIONS], 25), "text": None})
    measures = pd.DataFrame(rows)
    return measures.assign(value=measures["quartile"])


def alarms(measures: pd.DataFrame, first: int = 2) -> list[tuple[int, Finding]]:
    """(night, finding) of what is reported, night after night, from the first on."""
    known: list[Finding] = []
    told, nights = [], sorted(set(measures["night"]))
    for night in nights:
        if night < first:
            continue
        found = new_ones(step_findings(measures[measures["night"] <= night]), known, nights)
        known += found
        told += [(night, one) for one in found]
    return told


def simulate(noise: dict, trials: int, nights: int, slowdown: float, since: int, seed: int = 1) -> Rates:
    """`slowdown`: factor of one case's times from the night `since` on, in every trial of another case."""
    random, cases = np.random.default_rng(seed), sorted({case for case, _ in noise})
    false_alarms, found_after, wrong = 0, [], 0
    for trial in range(trials):
        measures = drawn_nights(noise, nights, random)
        false_alarms += bool(alarms(measures))
        slowed = cases[(CASE_STRIDE * trial) % len(cases)]
        measures.loc[(measures["case"] == slowed) & (measures["night"] >= since), ["value", "quartile"]] *= slowdown
        told = alarms(measures[measures["night"] < since + 5], since)
        found_after += [night - since + 1 for night, one in told if one.case == slowed][:1]
        wrong += any(one.case != slowed for _, one in told)
    return Rates(trials, nights, false_alarms, tuple(found_after), wrong)


def compared(noise: dict, trials: int, slowdown: float, seed: int = 1) -> tuple[int, int, int]:
    """Of comparisons of two interleaved programs: (false alarms where they are the same, slowdowns of one case found, other
    cases that alarmed then)."""
    random, cases = np.random.default_rng(seed), sorted({case for case, _ in noise})
    false_alarms, found, wrong = 0, 0, 0
    for trial in range(trials):
        moment, slowed = random.random(), cases[(CASE_STRIDE * trial) % len(cases)]
        before, after = (_drawn_set(noise, side, moment) for side in (0, 1))
        false_alarms += bool(compare(before, after).changes)
        for sample in after.cases[slowed]:
            sample.values.update({name: slowdown * value for name, value in sample.values.items() if name != "status"})
        changed = {row.case for row in compare(before, after).changes}
        found, wrong = found + (slowed in changed), wrong + bool(changed - {slowed})
    return false_alarms, found, wrong


def _drawn_set(noise: dict, side: int, moment: float) -> ResultSet:
    """Every second of the recorded ones, as if two programs had taken turns."""
    drawn = ResultSet(PROGRAM_SIDES[side])
    for (case, metric), values in noise.items():
        first = int(moment * max(0, len(values) - 2 * REPETITIONS + 1))
        chosen = values[first:first + 2 * REPETITIONS][side::2]
        samples = drawn.cases.setdefault(case, [])
        for repetition, value in enumerate(chosen):
            if repetition >= len(samples):
                run = Run(Path(f"{case}-r{repetition}"), {"status": "ok", "case": {}}, pd.DataFrame())
                samples.append(Sample(run, {"invocation": "drawn"}, repetition, {}))
            samples[repetition].values[metric] = 1e5 * value
    return drawn
