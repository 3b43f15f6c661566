"""Which figures of hard cases are known to be beyond their bars, and by how much: hard_reds.csv, a row a figure.

After a change that moves them: `tools/tests/hard_reds.py FOLDER` takes them from the matrix.csv that `musclebench hard --data DIR
--out FOLDER` wrote.
"""

import csv
import sys
from pathlib import Path

KNOWN = Path(__file__).with_name("hard_reds.csv")
COLUMNS = ("case", "backend", "figure", "value")
SHARE = 0.1  # by which a figure may move unseen

Red = tuple[str, str, str]


def rows_of(matrix: Path) -> list[dict[str, str]]:
    with matrix.open(newline="") as file:
        return list(csv.DictReader(file))


def reds_of(rows: list[dict[str, str]]) -> dict[Red, float]:
    """Of the rows of a matrix.csv: figures beyond their bars. No number is beyond any."""
    return {(row["case"], row["backend"], row["figure"]): float(row["value"])
            for row in rows if row["figure"] and not float(row["value"]) <= float(row["bar"])}


def known_reds() -> dict[Red, float]:
    return {(row["case"], row["backend"], row["figure"]): float(row["value"]) for row in rows_of(KNOWN)}


def sure_cells(rows: list[dict[str, str]]) -> set[tuple[str, str]]:
    """Those that were run to their end."""
    left_out = {(row["case"], row["backend"]) for row in rows
                if row["verdict"] == "not applicable" or "would take" in row["detail"]}
    return {(row["case"], row["backend"]) for row in rows} - left_out


def changes(rows: list[dict[str, str]], known: dict[Red, float]) -> list[str]:
    """A line for each red that is new, gone, worse or better. A cell that was not run to its end says nothing of what is
    gone."""
    found, asked = reds_of(rows), sure_cells(rows)
    lines = [f"{', '.join(red)}: {value:g}, was within its bar" for red, value in found.items() if red not in known]
    for red, before in known.items():
        if red in found:
            has_moved = not abs(found[red] - before) <= SHARE * abs(before) and str(found[red]) != str(before)
            lines += [f"{', '.join(red)}: {found[red]:g}, was {before:g}"] if has_moved else []
        elif red[:2] in asked:
            lines.append(f"{', '.join(red)}: within its bar, was {before:g}")
    return lines


def main() -> None:
    rows = rows_of(Path(sys.argv[1]) / "matrix.csv")
    asked = sure_cells(rows)
    kept = {red: value for red, value in known_reds().items() if red[:2] not in asked} if KNOWN.exists() else {}
    with KNOWN.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([*red, f"{value:.4g}"] for red, value in sorted((kept | reds_of(rows)).items()))


if __name__ == "__main__":
    main()
