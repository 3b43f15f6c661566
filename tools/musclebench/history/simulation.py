"""Nights that never were, drawn from recorded noise: how often an unchanged program alarms, and after how many nights a
slowdown is found; and how often the interleaved run of one night finds it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from ..comparison.metrics import METRICS
from ..comparison.result_set import ResultSet, Sample, match_frames
from ..comparison.verdicts import PROGRAM_SIDES, compare
from ..results.run_folder import Run
from ..results.statistics import percentile
from .detection import new_ones, step_findings
from .history import Finding

RECORDED = Path(__file__).resolve().parent / "recorded_noise.csv"
TIMES = ("collision_ns", "frame_ns", "cpu_ns", "build_ns")
MACHINE_SPREAD = 0.03  # of a night's machine, of all cases together: beyond what an hour's recording shows
REPETITIONS = 20  # of bench/experiments/nightly.toml
LEAST_SHARE = 0.05  # of a frame; less collision than that can't be slower in a way that one sees
CASE_STRIDE = 7  # of the sorted cases, so that a few trials take quiet and noisy ones


@dataclass(frozen=True)
class Noise:
    """Of one program that ran as two, interleaved."""

    times: dict[tuple[str, str], np.ndarray]  # {(case, metric): a row a round, a column a side}, in ns
    collision_shares: dict[str, float]  # {case: of the time of its frames}

    @property
    def slowed_cases(self) -> list[str]:
        """In which a slower backend can be seen."""
        return sorted(case for case, share in self.collision_shares.items() if share >= LEAST_SHARE)

    def factor(self, case: str, metric: str, slowdown: float) -> float:
        """Of the case's times where its collision takes `slowdown` times as long."""
        if metric == "build_ns":
            return 1.0
        return slowdown if metric == "collision_ns" else 1 + self.collision_shares[case] * (slowdown - 1)


@dataclass(frozen=True)
class Rates:
    trials: int
    nights: int
    false_alarms: int  # histories without a change in which something alarmed
    found_after: tuple[int, ...]  # nights after which the slowdown was found, of each trial that found it; 1: the same night
    wrong: int  # histories with a slowdown in which something else alarmed, too

    def found_within(self, nights: int) -> int:
        return sum(after <= nights for after in self.found_after)


def read_noise(path: Path = RECORDED) -> Noise:
    rows = pd.read_csv(path, comment="#")
    times = {}
    for case, group in rows.groupby("case"):
        for metric in TIMES:
            table = group.pivot(index="round", columns="program", values=metric)[list(PROGRAM_SIDES)].dropna()
            if len(table) >= REPETITIONS:
                times[case, metric] = table.to_numpy()
    return Noise(times, rows.groupby("case")["collision_share"].median().to_dict())


def noise_rows(before: ResultSet, after: ResultSet) -> pd.DataFrame:
    """What read_noise reads, of two sets of one program that ran interleaved: tools/compare PROGRAM COPY."""
    match_frames(before, after)
    rows = []
    for side, one in zip(PROGRAM_SIDES, (before, after)):
        for case, samples in one.cases.items():
            for sample in (sample for sample in samples if sample.tells_times):
                frames = sample.run.timed_frames
                rows.append({"round": sample.repetition, "program": side, "case": case,
                             **{metric: round(sample.values[metric]) if metric in sample.values else None for metric in TIMES},
                             "collision_share": round(float(frames["collision_ns"].sum() / frames["frame_ns"].sum()), 4)})
    return pd.DataFrame(rows).sort_values(["round", "case"], kind="stable").astype(dict.fromkeys(TIMES, "Int64"))


def drawn_nights(noise: Noise, nights: int, random: np.random.Generator) -> pd.DataFrame:
    """Of each night the lower quartiles of REPETITIONS that were recorded one after the other, from the same moment for all
    cases."""
    rows = []
    for night in range(1, nights + 1):
        moment, machine = random.random(), np.exp(random.normal(0, MACHINE_SPREAD))
        for (case, metric), values in noise.times.items():
            first = int(moment * (len(values) - REPETITIONS + 1))
            rows.append({"night": night, "case": case, "metric": metric, "kind": METRICS[metric].kind, "unit": "ns",
                         "quartile": machine * percentile(values[first:first + REPETITIONS, 0], 25), "text": None})
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


def simulate(noise: Noise, trials: int, nights: int, slowdown: float, since: int, seed: int = 1) -> Rates:
    """`slowdown`: factor of one case's collision from the night `since` on, in every trial of another case."""
    random, cases = np.random.default_rng(seed), noise.slowed_cases
    false_alarms, found_after, wrong = 0, [], 0
    for trial in range(trials):
        measures = drawn_nights(noise, nights, random)
        false_alarms += bool(alarms(measures))
        slowed = cases[(CASE_STRIDE * trial) % len(cases)]
        for metric in TIMES:
            chosen = (measures["case"] == slowed) & (measures["night"] >= since) & (measures["metric"] == metric)
            measures.loc[chosen, ["value", "quartile"]] *= noise.factor(slowed, metric, slowdown)
        told = alarms(measures[measures["night"] < since + 5], since)
        found_after += [night - since + 1 for night, one in told if one.case == slowed][:1]
        wrong += any(one.case != slowed for _, one in told)
    return Rates(trials, nights, false_alarms, tuple(found_after), wrong)


def compared(noise: Noise, trials: int, slowdown: float, seed: int = 1) -> tuple[int, int, int]:
    """Of nights in which the last night's program runs interleaved with tonight's, however few nights there were: (false alarms
    where they are the same, slowdowns of one case's collision found, other cases that alarmed then)."""
    random, cases = np.random.default_rng(seed), noise.slowed_cases
    false_alarms, found, wrong = 0, 0, 0
    for trial in range(trials):
        moment, slowed = random.random(), cases[(CASE_STRIDE * trial) % len(cases)]
        sides = random.permutation(2)
        before, after = (_drawn_set(noise, name, side, moment) for name, side in zip(PROGRAM_SIDES, sides))
        false_alarms += bool(compare(before, after).changes)
        for sample in after.cases[slowed]:
            sample.values.update({name: noise.factor(slowed, name, slowdown) * value for name, value in sample.values.items()})
        changed = {row.case for row in compare(before, after).changes}
        found, wrong = found + (slowed in changed), wrong + bool(changed - {slowed})
    return false_alarms, found, wrong


def _drawn_set(noise: Noise, name: str, side: int, moment: float) -> ResultSet:
    """Rounds that followed one another, the same of both sides."""
    drawn = ResultSet(name)
    for (case, metric), values in noise.times.items():
        first = int(moment * (len(values) - REPETITIONS + 1))
        samples = drawn.cases.setdefault(case, [])
        for repetition, value in enumerate(values[first:first + REPETITIONS, side]):
            if repetition >= len(samples):
                run = Run(Path(f"{case}-r{repetition}"), {"status": "ok", "case": {}}, pd.DataFrame())
                samples.append(Sample(run, {"invocation": "drawn"}, repetition, {}))
            samples[repetition].values[metric] = value
    return drawn
