"""Which case starts next."""

from types import SimpleNamespace

from musclebench.cases.case_queue import CaseQueue


def case(name: str, needs=(), wants_machine=False) -> SimpleNamespace:
    return SimpleNamespace(name=name, needs=needs, wants_machine=wants_machine)


def test_what_wants_the_machine_runs_alone_and_nobody_overtakes_it():
    first, alone, last = case("first"), case("alone", wants_machine=True), case("last")
    queue = CaseQueue([first, alone, last])
    assert queue.take() is first and queue.take() is None
    queue.end(first)
    assert queue.take() is alone and queue.take() is None
    queue.end(alone)
    assert queue.take() is last
    queue.end(last)
    assert not queue


def test_a_case_waits_for_what_it_needs_and_lets_others_go_first():
    needed, needing, other = case("a"), case("b", needs=("a",)), case("c")
    queue = CaseQueue([needing, needed, other])
    assert [queue.take(), queue.take(), queue.take()] == [needed, other, None]
    queue.end(needed)
    assert queue.take() is needing
