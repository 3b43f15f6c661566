"""Which case starts next."""

from .case import Case


class CaseQueue:
    """Cases in their order, but for those that have to wait: for another case, or for a machine of their own."""

    def __init__(self, cases: list[Case]):
        self._waiting = list(cases)
        self._running: list[Case] = []

    def __bool__(self) -> bool:
        return bool(self._waiting or self._running)

    def take(self) -> Case | None:
        """The first case that may start beside those that run; None when there is none."""
        pending = {case.name for case in self._waiting} | {case.name for case in self._running}
        for case in self._waiting:
            if self._has_room(case) and pending.isdisjoint(case.needs):
                self._waiting.remove(case)
                self._running.append(case)
                return case
        return None

    def end(self, case: Case) -> None:
        self._running.remove(case)

    def _has_room(self, case: Case) -> bool:
        alone = case.threads > 1 or any(running.threads > 1 for running in self._running)
        return not (alone and self._running)
