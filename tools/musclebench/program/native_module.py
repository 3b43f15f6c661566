"""The compiled part of the Python module (bench/python), for tools that ask its exact distances."""

import importlib
from pathlib import Path
from typing import Any

import musclebench

from .cli import Problem

NAME = "musclebench.native"


def add_native_module(program: Path) -> None:
    """Makes `native()` find the module of the build, or of the installation, that `program` belongs to. Raises Problem where it has none."""
    top = program.resolve().parent.parent
    for folder in (top / "python" / "musclebench", *top.glob("lib/python3*/*-packages/musclebench")):
        if any(folder.glob("native*.so")):
            musclebench.__path__.append(str(folder))  # last: it has copies of some modules of the tools
            native()
            return
    raise Problem(f"{program}: was built without its Python module; tools/setup pybind11-dev, then tools/build release")


def native() -> Any:
    """bench/python/package/native.pyi tells what it has. Raises Problem where Python can't load it."""
    try:
        return importlib.import_module(NAME)
    except ImportError as problem:
        raise Problem(f"{NAME}: {problem}; build the program with this Python ({Path(__file__).name})") from None
