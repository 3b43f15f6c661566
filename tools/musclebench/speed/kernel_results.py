"""What Google Benchmark wrote: samples of each kernel by the round and the repetition that they are from."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from ..experiments.kernels import KERNELS_FILE

NANOSECONDS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}
# Google Benchmark's own fields of a result; the others are the kernel's counters.
OWN_FIELDS = {"name", "family_index", "per_family_instance_index", "run_name", "run_type", "repetitions",
              "repetition_index", "threads", "iterations", "real_time", "cpu_time", "time_unit"}


@dataclass
class Kernels:
    """All results of an experiment's kernels."""

    samples: dict[tuple[str, str], dict[tuple, float]] = field(default_factory=dict)  # by (kernel, counter)
    problems: dict[str, str] = field(default_factory=dict)  # why a kernel measured nothing

    def of(self, kernel: str, counter: str, group: str | None = None) -> pd.Series:
        """Samples by (group, round, repetition); empty where there are none. `group` where one only counts."""
        samples = self.samples.get((kernel, counter), {})
        chosen = {key: value for key, value in samples.items() if group is None or key[0] == group}
        return pd.Series(chosen, dtype=float)

    def names(self, prefix: str) -> list[str]:
        """Of the kernels that measured something, in order."""
        return sorted({kernel for kernel, _ in self.samples if kernel.startswith(prefix)})


def read_kernels(raw_dir: Path) -> Kernels:
    """Of every complete group in the folder. A file that is no result of Google Benchmark counts as none."""
    kernels = Kernels()
    for path in sorted(raw_dir.glob(f"kernels-*/{KERNELS_FILE}")):
        try:
            case = json.loads((path.parent / "run.json").read_text())["case"]
            results = json.loads(path.read_text())["benchmarks"]
        except (OSError, ValueError, KeyError):
            continue
        for result in results:
            _add(kernels, (case["group"], case["repetition"]), result)
    return kernels


def _add(kernels: Kernels, source: tuple, result: dict) -> None:
    if result.get("run_type", "iteration") != "iteration":
        return  # means and medians, which are taken over all rounds here
    name = result.get("run_name", result["name"]).removesuffix("/real_time").removesuffix("/manual_time")
    name = re.sub(r"/iterations:\d+$", "", name)
    if result.get("error_occurred"):
        kernels.problems[name] = result.get("error_message", "no message")
        return
    key = (*source, result.get("repetition_index", 0))
    scale = NANOSECONDS[result.get("time_unit", "ns")]
    values = {"real_ns": scale * result["real_time"], "cpu_ns": scale * result["cpu_time"]}
    values |= {k: v for k, v in result.items() if k not in OWN_FIELDS and isinstance(v, (int, float))}
    for counter, value in values.items():
        kernels.samples.setdefault((name, counter), {})[key] = value
