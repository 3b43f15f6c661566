"""Whether other work disturbed a run: what the run says of the machine while it ran, and frames in which it waited."""

from collections.abc import Callable

import pandas as pd

BUSY_SWITCHES_A_SECOND = 20.0  # involuntary; a machine that is quiet has a few
FEWEST_SWITCHES = 5  # of a run of milliseconds a single one is many a second
SLOWEST_CLOCK_SHARE = 0.8  # of the median of the runs that are compared
NEIGHBOUR_FRAMES = 15
SLICE_MS = 1.0  # a slice of the scheduler is some milliseconds; what the method itself needs varies by less
SLICE_FACTOR = 1.5
MARK = " *"


def disturbance(record: dict, usual_mhz: float | None = None) -> str:
    """Why the run was disturbed, in words; empty where it was not, or where it does not tell. `usual_mhz`: the clock of
    the runs that it is compared with."""
    state = record.get("machine_state") or {}
    switches, load, mhz = state.get("involuntary_context_switches"), _worst(state, "load_average_1m", max), _clock_mhz(state)
    seconds = (record.get("wall_ns") or 0) / 1e9
    cores = (record.get("machine") or {}).get("cores")
    words = []
    if switches is not None and switches >= FEWEST_SWITCHES and 0 < seconds < switches / BUSY_SWITCHES_A_SECOND:
        words.append(f"interrupted {switches / seconds:.0f} times a second")
    if load is not None and cores and load > cores + 0.5:
        words.append(f"load {load:.1f} on {cores} cores")
    if mhz is not None and usual_mhz and mhz < SLOWEST_CLOCK_SHARE * usual_mhz:
        words.append(f"clock {mhz:.0f} MHz, usually {usual_mhz:.0f}")
    return ", ".join(words)


def usual_clock_mhz(records: list[dict]) -> float | None:
    clocks = [mhz for record in records if (mhz := _clock_mhz(record.get("machine_state") or {})) is not None]
    return float(pd.Series(clocks).median()) if clocks else None


def _clock_mhz(state: dict) -> float | None:
    return _worst(state, "cpu_mhz", min)


def _worst(state: dict, key: str, of: Callable) -> float | None:
    """Of what was read before and after the run; None where it could not be read."""
    told = [value for value in (state.get(key) or {}).values() if value is not None]
    return of(told) if told else None


def disturbed(named: dict[str, dict]) -> dict[str, str]:
    """{name: why} of the disturbed ones of {name: run.json}."""
    usual = usual_clock_mhz(list(named.values()))
    found = {name: disturbance(record, usual) for name, record in named.items()}
    return {name: why for name, why in found.items() if why}


def note(found: dict[str, str], count: int, shown: int = 5) -> str:
    """A line below a table; empty where nothing was disturbed."""
    if not found:
        return ""
    listed = "; ".join(f"{name} ({why})" for name, why in list(found.items())[:shown])
    more = f"; and {len(found) - shown} more" if len(found) > shown else ""
    return (f"*: the machine was busy in {len(found)} of {count} runs, so that their times are too long or vary too "
            f"much: {listed}{more}. Measure again on a quiet machine.")


def waits(times_ns: pd.Series) -> pd.Series:
    """True for frames in which the process waited for the processor: neighbours of the frame took much less."""
    usual = times_ns.rolling(NEIGHBOUR_FRAMES, center=True, min_periods=1).median()
    return (times_ns > SLICE_FACTOR * usual) & (times_ns - usual > 1e6 * SLICE_MS)
