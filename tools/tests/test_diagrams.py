"""The drawings of the pages are those that tools/draw_diagrams.py makes, and each is on a page."""

import re
import subprocess
import sys

import draw_diagrams
from copied_tools import PROJECT
from musclebench.diagrams import constraints


def test_pictures_are_as_they_are_drawn_and_shown(tmp_path):
    # In a process of its own: what other tests have set for their figures would show.
    subprocess.run([sys.executable, draw_diagrams.__file__, str(tmp_path)], check=True, stdout=subprocess.DEVNULL)
    drawn = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert {path.name: path.read_bytes() for path in draw_diagrams.FOLDER.iterdir()} == drawn
    pages = "".join(page.read_text() for page in [PROJECT / "CONTRIBUTING.md", *draw_diagrams.FOLDER.parent.rglob("*.md")])
    assert set(re.findall(r"\]\([\w./]*?pictures/([\w.]+)\)", pages)) == set(drawn)


def test_constraints_of_a_drawn_colour_share_no_node():
    colours = constraints.coloured(constraints.sheet()[1])
    assert all(len({node for pair in colour for node in pair}) == 4 * len(colour) for colour in colours)
