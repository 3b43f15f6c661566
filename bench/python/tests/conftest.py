"""Run by CTest with the built module on PYTHONPATH and MUSCLEBENCH_BINARY, the program of the same build."""

import os
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[3]
sys.path.append(str(PROJECT / "tools/tests"))

import ball_on_box  # noqa: E402  (found through the path that is set above)
import musclebench  # noqa: E402


def pytest_configure(config):
    config.addinivalue_line("markers", "long: `tools/test` leaves it out, too, unless it is told --all")


@pytest.fixture(scope="session")
def program() -> str:
    return os.environ["MUSCLEBENCH_BINARY"]


@pytest.fixture(scope="session")
def scene_file(tmp_path_factory) -> Path:
    """A ball that falls on a box."""
    folder = tmp_path_factory.mktemp("scene")
    ball_on_box.write_scene(folder)
    return folder / "scene.toml"


@pytest.fixture
def scene(scene_file):
    return musclebench.load_scene(scene_file)


@pytest.fixture(scope="session")
def ball() -> tuple:
    """Vertices and triangles of a ball of radius 0.1 m at (1, 0, 0)."""
    return ball_on_box.ball(0.1, (1.0, 0.0, 0.0), rings=60, around=80)
