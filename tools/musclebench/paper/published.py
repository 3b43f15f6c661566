"""The paper's numbers, from reports/published."""

import json
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

OWN_NAMES = {"discregrid": "sdf"}  # the paper's Discregrid stands beside both
PUBLISHED_DIR = Path(__file__).resolve().parents[3] / "reports" / "published"


@dataclass
class Published:
    memory_mb: pd.DataFrame  # index (muscle, backend); first_mb, last_mb
    headline: dict

    def memory(self, muscle: str, backend: str, column: str) -> float:
        """NaN where the paper has no such cell."""
        key = (muscle, OWN_NAMES.get(backend, backend))
        return float(self.memory_mb.loc[key, column]) if key in self.memory_mb.index else float("nan")

    def time_ratio(self, backend: str) -> str:
        return self.headline["collision_time_ratio_to_voxel"].get(OWN_NAMES.get(backend, backend), "")


def read_published(folder: Path = PUBLISHED_DIR) -> Published:
    memory = pd.read_csv(folder / "table_1_memory.csv").set_index(["muscle", "backend"])
    return Published(memory, json.loads((folder / "headline.json").read_text()))
