"""A tendon that a segmentation left out: a tube from the end of a muscle around bones to where it inserts, one surface with the muscle."""

from dataclasses import dataclass

import numpy as np
import vtk
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

from ..program.cli import Problem
from .mesh_file import mend
from .sewing import Unsewable, clipped, sew, without_bays, without_bumps
from .surface import Points, SignedDistance, Surface, Values, as_vtk, from_vtk
from .tendon_route import route

CELL_MM = 0.8
STEP_MM = 2.0  # between points of the path
TIP_MM = 12.0  # of the muscle's end, where the tube begins
BESIDE_TIP = slice(round(TIP_MM / STEP_MM), None)  # of a path: without the muscle's end, which may lie in a bone
GAP_MM = 0.5  # between tendon and bone
ROUNDS = 300
PUSHES = 20
FILLET_MM = 4.0  # how far tube and muscle are blended
SEAM_MM = 1.0  # its width, between what is drawn anew and the muscle's own triangles
SEAMS_MM = (0.0, 1.0, 2.0, 3.0, 4.0)  # how far beyond the blend it may be; the first that has as many loops on both sides
BAND_CELLS = 2.5


@dataclass
class Tendon:
    """Millimetres, in the frame of the meshes."""

    bone: str
    at: Points  # (3,) where it inserts
    through: Points  # (n, 3) places that it runs through, from the muscle on; sheaths and pulleys
    radius: float


def tendon_path(muscle: Surface, tendon: Tendon, bones: dict[str, Surface], muscles: dict[str, Surface] | None = None) -> Points:
    """Points from inside the muscle's end to the insertion, about STEP_MM apart: the shortest path through the given places that
    leaves room for the tendon beside bones and other muscles."""
    towards = tendon.through[0] if len(tendon.through) else tendon.at
    inner, tip = _end_of(muscle, towards)
    fields = {name: solid.distance for name, solid in (bones | (muscles or {})).items()}
    knots = np.concatenate([[inner, tip], tendon.through, [tendon.at]])
    for _ in range(PUSHES):  # places are told by eye, and may be too near to a bone; so may the muscle's end
        knots = _pushed_out(knots, np.zeros(len(knots), dtype=bool), fields, tendon)
    for k, place in enumerate((inner, tip)):
        if np.linalg.norm(knots[k] - place) > tendon.radius:  # a muscle that ends in a bone: that is told, and not mended here
            knots[k] = place
    legs = [np.array(leg) for leg in zip(knots[:-1], knots[1:])]
    straight = _shortened(legs, fields, tendon)
    if deepest_in_bones(straight, tendon, bones, BESIDE_TIP)[1] <= tendon.radius:
        return straight
    # Neighbouring places were pushed to opposite sides of a bone.
    ends = np.cumsum([0, *(_steps_of(leg) for leg in legs)])
    for k in range(1, len(legs)):
        if deepest_in_bones(straight, tendon, bones, slice(ends[k], ends[k + 1] + 1))[1] > tendon.radius:
            legs[k] = route(legs[k][0], legs[k][1], list(fields.values()), tendon.radius + GAP_MM)
    return min((straight, _shortened(legs, fields, tendon)), key=lambda path: deepest_in_bones(path, tendon, bones, BESIDE_TIP)[1])


def _steps_of(leg: Points) -> int:
    return max(1, round(float(np.linalg.norm(np.diff(leg, axis=0), axis=1).sum()) / STEP_MM))


def _shortened(legs: list[Points], fields: dict[str, SignedDistance], tendon: Tendon) -> Points:
    points, is_fixed = _subdivided(legs)
    for _ in range(ROUNDS):
        middles = points.copy()
        middles[1:-1] = (points[:-2] + points[2:]) / 2
        points = np.where(is_fixed[:, None], points, middles)
        points = _pushed_out(points, is_fixed, fields, tendon)
    return points


def deepest_in_bones(path: Points, tendon: Tendon, bones: dict[str, Surface], part: slice = slice(None)) -> tuple[str, float]:
    """How deep the tendon is in a bone, at its insertion without the bone that it ends on. More than its radius, and its middle is in the bone."""
    worst = ("", 0.0)
    dense = _dense(path[part])
    for name, bone in bones.items():
        points = dense[np.linalg.norm(dense - path[-1], axis=1) > 2 * tendon.radius] if name == tendon.bone else dense
        depth = float((tendon.radius - bone.distance.within(points, tendon.radius)).max(initial=0.0))
        worst = max(worst, (name, depth), key=lambda one: one[1])
    return worst


def with_tendon(muscle: Surface, path: Points, radius: float) -> Surface:
    """The muscle and a tube of `radius` around `path`, blended into each other; beyond `reach_of_tendon` the muscle's own triangles.
    Raises Problem where the two do not meet."""
    margin = radius + FILLET_MM + SEAMS_MM[-1] + 4 * CELL_MM
    low = path.min(axis=0) - margin
    shape = np.ceil((path.max(axis=0) + margin - low) / CELL_MM).astype(int) + 1
    in_muscle = _sampled(muscle, low, shape)
    tube = _tube(path, radius, low, shape)
    # Smooth minimum of two distances, by a cubic polynomial of their difference.
    blend = np.maximum(FILLET_MM - np.abs(in_muscle - tube), 0.0) / FILLET_MM
    united = _contour(np.minimum(in_muscle, tube) - blend**3 * FILLET_MM / 6, low)
    united.vertices = _on_muscle(united.vertices, muscle, path, radius + 0.9 * FILLET_MM)
    for seam in SEAMS_MM[:-1]:
        try:
            return mend(_sewn(muscle, united, path, reach_of_blend(radius) + seam), "muscle and tendon").surface
        except Unsewable:
            pass
    raise Problem("muscle and tendon do not meet in one closed surface; let `through` begin at the muscle's end")


def _sewn(muscle: Surface, united: Surface, path: Points, reach: float) -> Surface:
    """What comes to one side of the seam without crossing it stays whole."""
    far = reach + SEAM_MM
    of_muscle = without_bays(muscle, _to_path(muscle.vertices, path), reach, far)
    of_united = without_bumps(united, _to_path(united.vertices, path), reach, far)
    return sew(clipped(muscle, of_muscle, far, False), clipped(united, of_united, reach, True))


def reach_of_blend(radius: float) -> float:
    """How far from its path the tendon changes the muscle."""
    return radius + FILLET_MM


def reach_of_tendon(radius: float) -> float:
    """How far from its path the surface is another than the muscle's."""
    return radius + FILLET_MM + SEAMS_MM[-1]


def _to_path(points: Points, path: Points) -> Values:
    found: Values = cKDTree(_dense(path)).query(points)[0]
    return found


def _dense(path: Points) -> Points:
    return np.concatenate([start + np.linspace(0, 1, 16, endpoint=False)[:, None] * (end - start) for start, end in zip(path[:-1], path[1:])] + [path[-1:]])


def _on_muscle(vertices: Points, muscle: Surface, path: Points, reach: float) -> Points:
    """The grid has cut corners: what is farther from the path goes back to the muscle's surface."""
    away = np.flatnonzero(_to_path(vertices, path) > reach)
    distance = muscle.distance
    moved = vertices.copy()
    moved[away] -= distance(vertices[away])[:, None] * distance.gradients(vertices[away])
    return moved


def _end_of(muscle: Surface, towards: Points) -> tuple[Points, Points]:
    """A place inside the muscle and one at its tip, of the end that points to `towards`."""
    centre = muscle.vertices.mean(axis=0)
    axis = np.linalg.svd(muscle.vertices - centre, full_matrices=False)[2][0]
    axis *= np.sign(axis @ (towards - centre)) or 1.0
    along = (muscle.vertices - centre) @ axis
    tip = muscle.vertices[along > along.max() - TIP_MM / 3].mean(axis=0)
    inner = muscle.vertices[(along > along.max() - 2 * TIP_MM) & (along < along.max() - TIP_MM)].mean(axis=0)
    return inner, tip


def _subdivided(legs: list[Points]) -> tuple[Points, NDArray[np.bool_]]:
    """Places about STEP_MM apart; ends of legs stay, but for the first: the muscle's tip only says where to begin."""
    points, is_fixed = [legs[0][:1]], [True]
    for leg in legs:
        at = np.concatenate([[0.0], np.linalg.norm(np.diff(leg, axis=0), axis=1).cumsum()])
        wanted = np.linspace(0, at[-1], _steps_of(leg) + 1)[1:]
        points.append(np.column_stack([np.interp(wanted, at, leg[:, k]) for k in range(3)]))
        is_fixed += [False] * (len(wanted) - 1) + [True]
    is_fixed[len(points[1])] = False
    return np.concatenate(points), np.array(is_fixed)


def _pushed_out(points: Points, is_fixed: NDArray[np.bool_], fields: dict[str, SignedDistance], tendon: Tendon) -> Points:
    """The insertion lies on its bone: towards it the clearance goes to nothing."""
    moved = points.copy()
    clearance = tendon.radius + GAP_MM
    for name, field in fields.items():
        wanted = np.minimum(clearance, np.linalg.norm(points - points[-1], axis=1)) if name == tendon.bone else clearance
        lacking = wanted - field.within(moved, clearance)
        deep = np.flatnonzero((lacking > 0) & ~is_fixed)
        if len(deep):
            moved[deep] += lacking[deep, None] * field.gradients(moved[deep])
    moved[-1] = points[-1]
    return moved


def _nodes(low: Points, shape: NDArray[np.int_]) -> Points:
    axes = [low[k] + CELL_MM * np.arange(shape[k]) for k in range(3)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def _sampled(surface: Surface, low: Points, shape: NDArray[np.int_]) -> Values:
    """Signed distance at grid points: exact in a band around the surface, to a cell elsewhere."""
    stencil = vtk.vtkPolyDataToImageStencil()
    stencil.SetInputData(as_vtk(surface))
    stencil.SetOutputOrigin(*low)
    stencil.SetOutputSpacing(CELL_MM, CELL_MM, CELL_MM)
    stencil.SetOutputWholeExtent(0, int(shape[0]) - 1, 0, int(shape[1]) - 1, 0, int(shape[2]) - 1)
    filled = vtk.vtkImageStencilToImage()
    filled.SetInputConnection(stencil.GetOutputPort())
    filled.SetInsideValue(1)
    filled.SetOutsideValue(0)
    filled.Update()
    inside = vtk_to_numpy(filled.GetOutput().GetPointData().GetScalars()).reshape(shape[::-1]).transpose(2, 1, 0) > 0
    coarse = CELL_MM * (distance_transform_edt(~inside) - distance_transform_edt(inside))
    band = np.abs(coarse) < BAND_CELLS * CELL_MM
    coarse[band] = surface.distance(low + CELL_MM * np.argwhere(band))
    found: Values = coarse
    return found


def _tube(path: Points, radius: float, low: Points, shape: NDArray[np.int_]) -> Values:
    """Distance to a tube; where it is farther than the blend reaches, only that it is."""
    dense = _dense(path)
    reach = radius + 2 * FILLET_MM
    found: Values = np.full(shape, reach - radius)
    first = np.maximum(np.floor((dense.min(axis=0) - reach - low) / CELL_MM).astype(int), 0)
    last = np.minimum(np.ceil((dense.max(axis=0) + reach - low) / CELL_MM).astype(int) + 1, shape)
    part = tuple(slice(a, b) for a, b in zip(first, last))
    nodes = _nodes(low + CELL_MM * first, last - first)
    distances, _ = cKDTree(dense).query(nodes.reshape(-1, 3), distance_upper_bound=reach)
    found[part] = np.minimum(distances, reach).reshape(nodes.shape[:3]) - radius
    return found


def _contour(values: Values, low: Points) -> Surface:
    image = vtk.vtkImageData()
    image.SetDimensions(*values.shape)
    image.SetOrigin(*low)
    image.SetSpacing(CELL_MM, CELL_MM, CELL_MM)
    image.GetPointData().SetScalars(numpy_to_vtk(values.transpose(2, 1, 0).ravel(), deep=True))
    contour = vtk.vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    contour.ComputeNormalsOff()
    contour.Update()
    found = from_vtk(contour.GetOutput())
    return Surface(found.vertices, found.triangles[:, ::-1])  # outward: VTK's face where values fall
