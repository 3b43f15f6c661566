"""What a finished case depends on; it is run again when any of it has changed."""

import hashlib
import json
import os
from pathlib import Path

FILE_NAME = "case.json"


def file_digest(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def text_digest(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()


def data_digest(data_dir: Path | None) -> str:
    """Of lhdl.json and the meshes; empty without a data folder."""
    if data_dir is None:
        return ""
    files = [data_dir / "lhdl.json", *sorted((data_dir / "meshes").glob("*.ply"))]
    return hashlib.sha256("".join(file_digest(path) for path in files if path.is_file()).encode()).hexdigest()


def fingerprint(arguments: list[str], binary_digest: str, data: str, **more: str) -> dict:
    """`more`: digests of further inputs, by name."""
    return {"arguments": arguments, "binary_sha256": binary_digest, "data_sha256": data, **more}


def seal(folder: Path, print_of_case: dict) -> None:
    """Notes in the folder what the run depended on."""
    (folder / FILE_NAME).write_text(json.dumps(print_of_case) + "\n")


def write_whole(path: Path, text: str | bytes) -> None:
    """Under a temporary name first: the file is there whole or as it was."""
    part = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        part.write_bytes(text if isinstance(text, bytes) else text.encode())
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def status_when_sealed(folder: Path, print_of_case: dict, by_any_program: bool = False) -> str | None:
    """Status of the run in the folder; None unless it is of just this case, build and data. `by_any_program`: of this case
    and data."""
    try:
        noted = json.loads((folder / FILE_NAME).read_text())
        status = json.loads((folder / "run.json").read_text())["status"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    if by_any_program and isinstance(noted, dict):
        noted = noted | {"binary_sha256": print_of_case["binary_sha256"]}
    return status if noted == print_of_case else None
