"""Joint angle tables (.mot of OpenSim)."""

from pathlib import Path

from .upstream import ImportProblem

COLUMNS = ["time", "hip_flexion_r", "hip_adduction_r", "hip_rotation_r"]


def read_motion(path: Path, file_name: str) -> dict:
    """The rows that are there (one header announces more), time in seconds, angles in degrees."""
    lines = path.read_text(encoding="latin-1").splitlines()
    try:
        start = [line.strip() for line in lines].index("endheader") + 1
        header = lines[start].split()
        wanted = [header.index(name) for name in COLUMNS]
        rows = [[float(line.split()[i]) for i in wanted] for line in lines[start + 1 :] if line.strip()]
    except (ValueError, IndexError):
        raise ImportProblem(f"{path}: not an OpenSim motion with columns {', '.join(COLUMNS)}; fetch the file again") from None
    motion = {"file": file_name, "frames": len(rows), "columns": COLUMNS, "rows": rows}
    announced = next((int(line.split("=")[1]) for line in lines if line.startswith("nRows=")), len(rows))
    if announced != len(rows):
        motion["note"] = f"The header announces {announced} rows; {len(rows)} are there."
    return motion
