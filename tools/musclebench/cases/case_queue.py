"""Which case starts next."""

from .case import Case


class CaseQueue:
    """Cases in their order, but for those that have to wait: for another case, or for a machine of their own."""

    def __init__(self, cases: list[Case]):
        self._waiting = list(cases)
        self._running: list[Case] = []
        self._pending = {case.name for case in cases}

    def __bool__(self) -> bool:
        return bool(self._waiting or self._running)

    @property
    def waiting(self) -> int:
        return len(self._waiting)

    def take(self) -> Case | None:
        """The first case that has what it needs, if it may start beside those that run; None when there is none."""
        ready = next((case for case in self._waiting if self._pending.isdisjoint(case.needs)), None)
        # Nobody overtakes it: a case that wants the machine for itself would otherwise have its turn after all others.
        if ready is None or not self._has_room(ready):
            return None
        self._waiting.remove(ready)
        self._running.append(ready)
        return ready

    def end(self, case: Case) -> None:
        self._running.remove(case)
        self._pending.discard(case.name)

    def _has_room(self, case: Case) -> bool:
        alone = case.wants_machine or any(running.wants_machine for running in self._running)
        return not (alone and self._running)
