"""Reader of legacy VTK polygon data (the format of VTK 5 and older), ASCII and big-endian binary."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .upstream import ImportProblem


@dataclass
class PolyData:
    points: np.ndarray  # (n, 3) float32, in the file's unit
    cells: np.ndarray  # (m, k) int, all cells of one size (3: triangles, 2: segments)


class _Cursor:
    """Walks over a file that mixes text lines with binary blocks."""

    def __init__(self, path: Path):
        self.path, self.data, self.at = path, path.read_bytes(), 0

    def line(self) -> str:
        end = self.data.find(b"\n", self.at)
        if end < 0:
            raise ImportProblem(f"{self.path}: ends too early; fetch the file again")
        text, self.at = self.data[self.at : end], end + 1
        return text.decode("latin-1").strip()

    def seek_keyword(self, *keywords: str) -> list[str]:
        while True:
            words = self.line().split()
            if words and words[0] in keywords:
                return words

    def numbers(self, count: int, binary: bool, text_type: str, binary_type: str) -> np.ndarray:
        if not binary:
            return self._text_numbers(count, text_type)
        end = self.at + count * np.dtype(binary_type).itemsize
        if end > len(self.data):
            raise ImportProblem(f"{self.path}: ends too early; fetch the file again")
        block, self.at = self.data[self.at : end], end
        return np.frombuffer(block, binary_type).astype(text_type)

    def _text_numbers(self, count: int, text_type: str) -> np.ndarray:
        words: list[str] = []
        while len(words) < count:
            words.extend(self.line().split())
        return np.array(words[:count], dtype=np.float64).astype(text_type)


def read_legacy_vtk(path: Path) -> PolyData:
    """Points and cells exactly as the file has them; raises ImportProblem for anything else than one-size cells."""
    cursor = _Cursor(path)
    if not cursor.line().startswith("# vtk DataFile"):
        raise ImportProblem(f"{path}: not a legacy VTK file; fetch the file again")
    cursor.line()
    binary = cursor.seek_keyword("ASCII", "BINARY")[0] == "BINARY"
    points_header = cursor.seek_keyword("POINTS")
    if points_header[2] != "float":
        raise ImportProblem(f"{path}: points are {points_header[2]}, not float; fetch the file again")
    points = cursor.numbers(3 * int(points_header[1]), binary, "f4", ">f4").reshape(-1, 3)
    cells_header = cursor.seek_keyword("POLYGONS", "LINES")
    cell_count, number_count = int(cells_header[1]), int(cells_header[2])
    table = cursor.numbers(number_count, binary, "i4", ">i4").reshape(cell_count, -1)
    size = table.shape[1] - 1
    if np.any(table[:, 0] != size) or np.any(table[:, 1:] < 0) or np.any(table[:, 1:] >= len(points)):
        raise ImportProblem(f"{path}: cells must all have {size} corners that exist; fetch the file again")
    return PolyData(points, table[:, 1:])
