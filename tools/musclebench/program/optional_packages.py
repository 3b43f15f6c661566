"""Packages that only pictures and exports need. Where Python lacks one, stand-ins let the modules that draw be imported, and
what they would have drawn is left out with one line."""

import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType

from .cli import Problem

OPTIONAL = {"matplotlib": "python3-matplotlib", "vtk": "python3-vtk9", "vtkmodules": "python3-vtk9"}


class PackageMissing(Problem):
    """One line with the package and the cure."""


def refuse(package: str) -> None:
    raise PackageMissing(f"Python lacks {package} (tools/setup installs {OPTIONAL[package]})")


class _StandInType(type):
    """Of classes that stand for whatever a missing package has. Naming and inheriting them is harmless, and so is making
    matplotlib's formatters and colours, which modules do while they are imported; pyplot's and VTK's functions draw."""

    def __getattr__(cls, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        return _stand_in(f"{cls.path}.{name}")

    def __call__(cls, *_, **__):
        if cls.path.startswith("matplotlib") and ".pyplot" not in cls.path:
            return _stand_in(f"{cls.path}.made")
        refuse(cls.path.partition(".")[0])


def _stand_in(path: str) -> type:
    return _StandInType(path.rpartition(".")[2], (), {"path": path})


class _StandInModule(ModuleType):
    def __getattr__(self, name: str):
        if name.startswith("__"):
            raise AttributeError(name)
        return _stand_in(f"{self.__name__}.{name}")


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def __init__(self, packages: list[str]):
        self._packages = packages

    def find_spec(self, name, path=None, target=None):
        is_mine = name.partition(".")[0] in self._packages
        return importlib.machinery.ModuleSpec(name, self, is_package=True) if is_mine else None

    def create_module(self, spec):
        return _StandInModule(spec.name)

    def exec_module(self, module):
        pass


def stand_in_for_missing() -> None:
    missing = [name for name in OPTIONAL if importlib.util.find_spec(name) is None]
    for name in missing:
        sys.modules.pop(name, None)  # None there forbids the import
    if missing:
        sys.meta_path.insert(0, _Finder(missing))


def is_there(package: str) -> bool:
    return not isinstance(importlib.import_module(package), _StandInModule)


def require(*packages: str) -> None:
    """For what is not drawn by functions of theirs that are called here."""
    for name in packages:
        if not is_there(name):
            refuse(name)


@contextmanager
def left_out_without(what: str) -> Iterator[None]:
    """Around what draws: says which of it there is not."""
    try:
        yield
    except PackageMissing as problem:
        print(f"left out {what}: {problem}", file=sys.stderr)
