"""The page of scenes names every key that the reader takes, and no other."""

import re
from pathlib import Path

PROJECT = Path(__file__).resolve().parent.parent.parent
READERS = [PROJECT / "core/scene" / name
           for name in ("read_scene.cpp", "read_motion.cpp", "read_contact.cpp", "read_attachments.cpp", "read_retinacula.cpp", "read_placement.hpp")]


def keys_of_the_reader() -> set[str]:
    text = "".join(file.read_text() for file in READERS)
    lists = re.findall(r"(?:allow_only\(|body_keys\(|placement_keys = )\{(.*?)\}", text, re.S)
    meshes = re.search(r"mesh_parameters\(\) \{(.*?)\n\}", (PROJECT / "core/scene/scene.cpp").read_text(), re.S)
    wanted = re.search(r"wanted_parameters\(\) \{(.*?)\n\}", (PROJECT / "core/scene/wanted.cpp").read_text(), re.S)
    return ({key for found in lists for key in re.findall(r'"(\w+)"', found)} | set(re.findall(r'\.name = "(\w+)"', meshes.group(1)))
            | set(re.findall(r'(?:length_mm\(|\.name = )"(\w+)"', wanted.group(1))))


def keys_of_the_page() -> set[str]:
    _, _, reference = (PROJECT / "datasets/README.md").read_text().partition("| table | key |")
    rows = [line.split("|")[1:3] for line in reference.splitlines()[1:] if line.startswith("|")]
    tables = {name.split(".")[0] for table, _ in rows for name in re.findall(r"`\[+([\w.]+)\]+`", table)}
    nested = {name.split(".")[1] for table, _ in rows for name in re.findall(r"`\[+(\w+\.[a-z]+)\]+`", table)}
    return tables | nested | {key for _, cell in rows for key in re.findall(r"`(\w+)`", cell)}


def test_the_page_has_the_keys_of_the_reader():
    assert len(keys_of_the_reader()) > 25
    assert keys_of_the_page() == keys_of_the_reader()
