"""What a finished case depends on; it is run again when any of it has changed."""

import hashlib
import json
from pathlib import Path

FILE_NAME = "case.json"


def file_digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def data_digest(data_dir: Path | None) -> str:
    """Of lhdl.json and the meshes; empty without a data folder."""
    if data_dir is None:
        return ""
    files = [data_dir / "lhdl.json", *sorted((data_dir / "meshes").glob("*.ply"))]
    return hashlib.sha256("".join(file_digest(path) for path in files if path.is_file()).encode()).hexdigest()


def fingerprint(arguments: list[str], binary_digest: str, data: str) -> dict:
    return {"arguments": arguments, "binary_sha256": binary_digest, "data_sha256": data}


def seal(folder: Path, print_of_case: dict) -> None:
    """Notes in the folder what the run depended on."""
    (folder / FILE_NAME).write_text(json.dumps(print_of_case) + "\n")


def is_complete(folder: Path, print_of_case: dict) -> bool:
    """True when the folder holds an `ok` run of just this case, build and data."""
    try:
        noted = json.loads((folder / FILE_NAME).read_text())
        status = json.loads((folder / "run.json").read_text())["status"]
    except (OSError, ValueError, KeyError):
        return False
    return status == "ok" and noted == print_of_case and (folder / "frames.csv").is_file()
