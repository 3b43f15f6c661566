"""The compiled part of the Python module (bench/python), for tools that ask its exact distances."""

import importlib
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any

import musclebench

from .cli import Problem

NAME = "musclebench.native"


def add_native_module(program: Path) -> None:
    """Makes `native()` find the module of the build, or of the installation, that `program` belongs to. Raises Problem where it has none
    for this Python."""
    top = program.resolve().parent.parent
    for folder in (top / "python" / "musclebench", *top.glob("lib/python3*/*-packages/musclebench")):
        if any((folder / f"native{suffix}").is_file() for suffix in EXTENSION_SUFFIXES):
            if str(folder) not in musclebench.__path__:
                musclebench.__path__.append(str(folder))  # the last place: modules beside `native` are copies of those here
            native()
            return
    raise Problem(f"{program}: has no Python module beside it; run tools/setup pybind11-dev, and then tools/build release")


def native() -> Any:
    """bench/python/package/native.pyi tells what it has. Raises Problem where Python can't load it."""
    try:
        return importlib.import_module(NAME)
    except ImportError as problem:
        raise Problem(f"{NAME}: {problem}; build the program anew on this machine") from None
