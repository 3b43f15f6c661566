"""draw_pictures.py, which fails where something in a figure covers what it must not."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import draw_pictures  # noqa: E402  (found through the path that is set above)
from musclebench.figures import style  # noqa: E402
from musclebench.figures.collisions import collisions  # noqa: E402

save = style.save_figure


def watched(figure, stem):
    if found := collisions(figure):
        raise AssertionError(f"{stem.name}: {found}")
    return save(figure, stem)


style.save_figure = watched
if __name__ == "__main__":
    sys.exit(draw_pictures.main(sys.argv[1:]))
