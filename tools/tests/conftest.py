"""Shared fixtures; the tools folder goes on the path as it does for the scripts in it."""

import signal
import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(TOOLS), str(TOOLS / "tests")]
# A shell without job control has its background jobs ignore this signal, and so would every program under test.
signal.signal(signal.SIGINT, signal.default_int_handler)

import ball_on_box  # noqa: E402  (found through the path that is set above)
import fake_registry  # noqa: E402
import fake_runs  # noqa: E402
from program import find_lhdl  # noqa: E402
from musclebench.figures import looks, style  # noqa: E402
from musclebench.figures.collisions import collisions  # noqa: E402
from musclebench.pictures import in_display  # noqa: E402


@pytest.fixture(autouse=True, scope="session")
def watched_figures():
    """Every figure that a test draws and saves is looked through for words that are cut or covered."""
    save = style.save_figure

    def watched(figure, stem):
        assert collisions(figure) == [], stem.name
        return save(figure, stem)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(style, "save_figure", watched)
        patch.setattr(in_display, "DRAWING", TOOLS / "tests" / "draw_watched.py")
        yield


@pytest.fixture(autouse=True, scope="session")
def cache_of_the_tests(tmp_path_factory):
    """What searches for effects found before decides no test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="session")
def lhdl_folder() -> Path:
    """The LHDL data folder; skips where it is absent."""
    if folder := find_lhdl():
        return folder
    pytest.skip("LHDL data not found: set MUSCLEBENCH_DATA to the folder with lhdl.json (datasets/README.md: how to get it)")


@pytest.fixture(scope="session")
def lhdl_upstream(lhdl_folder) -> Path:
    """The upstream checkouts beside the data folder; skips where they are absent."""
    upstream = lhdl_folder / "upstream"
    if not (upstream / "SHA256SUMS").is_file():
        pytest.skip(f"LHDL upstream files not found: {upstream} has no SHA256SUMS")
    return upstream


@pytest.fixture
def fake_raw(tmp_path) -> Path:
    """Run folders of 4 muscles x 4 backends with the known numbers of fake_runs.py."""
    raw = tmp_path / "raw"
    for muscle in fake_runs.MUSCLES:
        for backend in fake_runs.backends():
            fake_runs.write_run(raw / f"{muscle}-{backend}", f"synthetic/{muscle}", backend)
    return raw


@pytest.fixture(autouse=True)
def known_backends():
    """Figures look as the project's own list of backends says."""
    looks.know(fake_registry.registry())


@pytest.fixture
def study(tmp_path) -> Path:
    """The replays of two muscles with the known numbers of fake_study.REPLAYED."""
    import fake_study  # only here: it needs the report, the other tests do not

    fake_study.write_muscles(tmp_path)
    return tmp_path


@pytest.fixture
def folder(tmp_path) -> Path:
    """With scene.toml, a ball that falls on a box."""
    ball_on_box.write_scene(tmp_path)
    return tmp_path
