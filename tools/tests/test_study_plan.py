"""Which cases the accuracy study has, in which order, and what may run beside what."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

import fake_registry
from musclebench.cases.case import Folders
from musclebench.cases.case_queue import CaseQueue
from musclebench.study.study_cases import CoupledCase, MeasuredCase, ProbeCase, RecordCase, ReplayCase
from musclebench.study import study_plan
from musclebench.study.study_plan import Request, in_shard, is_too_long, stride_of
from musclebench.study.sweeps import Configuration, configurations

FOLDERS = Folders(Path("out"), Path("data"))
MUSCLES = fake_registry.scenes("lhdl")
ILIACUS = fake_registry.scene("lhdl/iliacus")
FULL = Request((ILIACUS,), "lhdl")
ALL = configurations(fake_registry.registry())


def plan(request):
    return study_plan.plan(request, ALL)


def measured(request):
    return [case for case in plan(request) if isinstance(case, MeasuredCase)]


def seconds(cases):
    return sum(case.guessed_seconds for case in cases if not is_too_long(case))


def test_names_are_unique_and_every_muscle_is_recorded_first():
    cases = plan(Request(MUSCLES, "lhdl"))
    assert len({case.name for case in cases}) == len(cases)
    assert [case.scene for case in cases[:4]] == list(MUSCLES)
    assert all(isinstance(case, RecordCase) for case in cases[:4])


def test_the_full_study_has_what_the_study_asks_for():
    firsts = [case for case in measured(FULL) if case.repetition == 0]
    count = Counter((case.mode, case.configuration.backend) for case in firsts)
    assert count["replay", "voxel"] == count["coupled", "voxel"] == count["probe", "voxel"] == 9
    assert count["replay", "sdf"] == count["coupled", "sdf"] == 19 and count["probe", "sdf"] == 18
    assert count["replay", "fcl"] > 20 and count["coupled", "fcl"] > 20
    assert count["replay", "bvh"] == count["coupled", "bvh"] == 2 and count["replay", "brute_force"] == 1
    assert count["coupled", "null"] == 1 and count["replay", "null"] == 0
    cells = {dict(c.configuration.parameters).get("cells") for c in firsts if c.configuration.backend == "voxel"}
    assert {16, 32, 64, 128, 256} <= cells


@pytest.mark.parametrize("backend", ["sdf", "bvh"])
def test_the_study_shows_runs_with_and_without_a_clearance_cache(backend):
    chosen = [c.configuration for c in measured(FULL) if c.configuration.backend == backend]
    assert {configuration.has_cache for configuration in chosen} == {True, False}


def test_repetitions_come_round_by_round_and_shuffled():
    cases = measured(FULL)
    rounds = [case.repetition for case in cases]
    assert rounds == sorted(rounds) and set(rounds) == {0, 1, 2}
    orders = [[c.name[:-3] for c in cases if c.repetition == r and c.configuration.backend == "voxel"
               and not isinstance(c, ProbeCase)] for r in range(3)]
    assert sorted(orders[0]) == sorted(orders[1]) == sorted(orders[2])
    assert orders[0] != orders[1] != orders[2] != sorted(orders[0])
    assert plan(FULL) == plan(FULL) != plan(Request((ILIACUS,), "lhdl", seed=2))


def test_only_the_first_repetition_is_judged_and_keeps_shapes():
    for case in measured(FULL):
        words = case.arguments(FOLDERS)
        is_first = case.repetition == 0
        assert ("--no-referee" in words) != is_first
        assert ("--snapshots" in words) == (is_first and isinstance(case, CoupledCase))


def test_long_cases_are_repeated_less():
    count = Counter((case.mode, case.configuration.label) for case in measured(FULL))
    assert count["replay", "voxel-cells=64"] == 3
    assert count["coupled", "fcl"] == 2
    assert count["replay", "brute_force"] == 1


def test_work_keeps_to_the_promised_minutes():
    assert seconds(plan(FULL)) / 2 < 30 * 60
    assert seconds(plan(Request((fake_registry.scene("synthetic/iliacus"),), quick=True, repetitions=1))) / 2 < 4.5 * 60


def test_brute_force_is_run_where_it_is_affordable():
    too_long = [case.name for case in plan(Request(MUSCLES, "lhdl")) if is_too_long(case)]
    replays = [name for name in too_long if "-replay-" in name]
    assert len(too_long) - len(replays) == len(MUSCLES) and all("brute_force" in name for name in too_long)
    assert replays and "adductor_brevis-replay-brute_force-r0" not in replays
    floors = [case for case in plan(Request(MUSCLES, "lhdl")) if "-floor-" in case.name]
    assert [case.configuration.label for case in floors] == ["bvh"] * len(MUSCLES)
    assert "start_noise_m=1e-12" in floors[0].arguments(FOLDERS)


def test_moment_arms_are_of_runs_of_their_own():
    scene = replace(ILIACUS, preset="standard")
    cases = [case for case in plan(Request((ILIACUS,), "lhdl", arm_scenes=(scene,))) if "-arms" in case.name]
    coupled = [case for case in plan(FULL) if "-coupled-" in case.name and case.repetition == 0 and case.threads == 1]
    assert len(cases) == len(coupled) + 1 and all(case.repetition == 0 for case in cases)
    words = next(case for case in cases if case.name == "iliacus-arms-bvh-r0").arguments(FOLDERS)
    assert words[words.index("--preset") + 1] == "standard" and words[words.index("--fibres-if-possible") + 1] == "100"
    assert "--no-referee" in words and "--snapshots" not in words
    floor, = [case for case in cases if case.mode == "arms_floor"]
    assert floor.name == "iliacus-arms_floor-bvh-r0" and "start_noise_m=1e-12" in floor.arguments(FOLDERS)


@pytest.mark.parametrize("milliseconds", [0.0, 0.1, 10.0, 100.0, 1e4])
def test_strides_are_powers_of_two_that_keep_enough_frames(milliseconds):
    configuration = Configuration("a backend of its own", step_ms=milliseconds)
    stride = stride_of(ILIACUS, configuration, 12.0)
    replay = ReplayCase(ILIACUS, configuration, stride=stride)
    assert stride in (1, 2, 4, 8, 16) and replay.frames >= 20
    assert replay.guessed_step_seconds <= 12.0 or stride == 16
    assert stride == 1 or ReplayCase(ILIACUS, configuration, stride=stride // 2).guessed_step_seconds > 12.0


def test_configurations_of_a_backend_replay_the_same_frames_and_all_of_them_with_a_clearance_cache():
    strides = {}
    for case in plan(Request(MUSCLES, "lhdl")):
        if isinstance(case, ReplayCase):
            key = (case.scene.key, case.configuration.backend, case.configuration.has_cache)
            strides.setdefault(key, set()).add(case.stride)
    assert all(len(of_backend) == 1 for of_backend in strides.values())
    assert all(of_backend == {1} for (_, _, has_cache), of_backend in strides.items() if has_cache)


@pytest.mark.parametrize("count", [1, 2, 3, 7, 100])
def test_parts_are_disjoint_complete_and_even(count):
    whole = measured(Request(MUSCLES, "lhdl"))
    parts = [in_shard(whole, number, count) for number in range(1, count + 1)]
    assert sorted(case.name for part in parts for case in part) == sorted(case.name for case in whole)
    if count <= 7:
        assert max(map(seconds, parts)) < 1.3 * seconds(whole) / count


def test_a_part_records_only_the_muscles_that_it_replays():
    for number in (1, 2, 3):
        cases = plan(Request(MUSCLES, "lhdl", shard=(number, 3)))
        replayed = {case.scene for case in cases if isinstance(case, ReplayCase)}
        assert {case.scene for case in cases if isinstance(case, RecordCase)} == replayed


def test_a_configuration_stays_in_one_part():
    parts = [in_shard(measured(FULL), number, 4) for number in (1, 2, 3, 4)]
    labels = [{case.configuration.label for case in part} for part in parts]
    assert sum(map(len, labels)) == len(set().union(*labels)) == len(ALL)


def test_a_queue_keeps_cases_until_what_they_need_has_ended():
    sdf = Configuration("sdf", (("cells", 8),), storage="structures")
    probe, replay, recording = ProbeCase(ILIACUS.probed, sdf), ReplayCase(ILIACUS, sdf), RecordCase(ILIACUS)
    queue = CaseQueue([replay, recording, probe])
    assert queue.take() == recording and queue.take() == probe and queue.take() is None
    queue.end(recording)
    assert queue.take() is None
    queue.end(probe)
    assert queue.take() == replay
    queue.end(replay)
    assert not queue


def test_a_queue_gives_several_threads_a_machine_of_their_own():
    wide, narrow = CoupledCase(ILIACUS, Configuration("fcl", threads=2)), CoupledCase(ILIACUS, Configuration("null"))
    queue = CaseQueue([narrow, wide])
    assert queue.take() == narrow and queue.take() is None
    queue.end(narrow)
    assert queue.take() == wide
    queue = CaseQueue([wide, narrow])
    assert queue.take() == wide and queue.take() is None


def test_a_queue_lets_nobody_overtake_a_case_of_several_threads():
    wide, narrow = CoupledCase(ILIACUS, Configuration("fcl", threads=2)), CoupledCase(ILIACUS, Configuration("null"))
    later = [CoupledCase(ILIACUS, Configuration("null"), repetition) for repetition in (1, 2)]
    queue = CaseQueue([narrow, wide, *later])
    assert queue.take() == narrow and queue.take() is None  # with one core free: the wide case wants all of them
    queue.end(narrow)
    assert queue.take() == wide and queue.take() is None
    queue.end(wide)
    assert [queue.take(), queue.take()] == later


def test_a_queue_goes_past_a_case_of_several_threads_that_waits_for_another():
    two_threads = Configuration("sdf", storage="structures", threads=2)
    wide, probe = CoupledCase(ILIACUS, two_threads), ProbeCase(ILIACUS.probed, two_threads)
    narrow = CoupledCase(ILIACUS, Configuration("null"))
    queue = CaseQueue([wide, narrow, probe])
    assert wide.needs == (probe.name,)
    for case in (narrow, probe, wide):
        assert queue.take() == case and queue.take() is None
        queue.end(case)
    assert not queue


def test_what_is_too_long_is_a_choice():
    cases = plan(Request(MUSCLES, "lhdl", longest_seconds=50.0))
    kept = [case.guessed_seconds for case in cases if not is_too_long(case) and case.name.endswith("-r0")]
    more = [case.guessed_seconds for case in plan(Request(MUSCLES, "lhdl")) if not is_too_long(case)]
    assert max(kept) <= 50 < max(more)
