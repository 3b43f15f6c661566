"""Landmark clouds of the .nms file (XML of nmsBuilder): attachment outlines and anatomical points."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from .upstream import ImportProblem

THIGH_CLOUD = "BL_R_Thigh_Ref_system"


def read_landmark_clouds(path: Path) -> dict[str, dict[str, list[float]]]:
    """{cloud: {landmark: [x, y, z] in metres}}; landmarks with numbers for names come in numeric order."""
    clouds = {}
    for node in ElementTree.parse(path).getroot().iter("Node"):
        if node.get("Type") != "albaVMELandmarkCloud":
            continue
        points = {mark.get("Name"): _position_m(path, mark) for mark in node.findall("./Children/Node")}
        names = sorted(points, key=int) if all(name.isdigit() for name in points) else points
        clouds[node.get("Name")] = {name: points[name] for name in names}
    return clouds


def _position_m(path: Path, mark) -> list[float]:
    matrix = mark.find("./MatrixVector/Matrix")
    if matrix is None:
        raise ImportProblem(f"{path}: landmark {mark.get('Name')} has no position; fetch the file again")
    numbers = [float(word) for word in matrix.text.split()]
    return [round(numbers[i] / 1000.0, 9) for i in (3, 7, 11)]
