"""Pictures of single snapshots: the muscle coloured by depth on posed bones, and its bound nodes."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from scipy.spatial import cKDTree

from ..results.ply import PlyMesh
from ..results.run_folder import Run
from ..results.snapshots import Snapshot, read_bones, read_snapshots
from . import views
from .rendering import CutPlane, Scene3d, View

PICTURE_PIXELS = 620
MUSCLE_COLOUR = np.array([178, 88, 80])
DEPTH_COLOURS = LinearSegmentedColormap.from_list("depth", ["#9fe8f2", "#37a7d8", "#1f4fb0", "#120a5c"])
INSIDE_FROM_MM = 0.02  # shallower than this counts as touching
SEE_THROUGH_BONE = 0.2
SEE_THROUGH_MUSCLE = 0.35
SEE_THROUGH_SKIN = 0.15
BALL_SHARE = 0.011  # radius of a marked node, of half the picture's height
FEW, FEW_GROW = 100, 2.2  # so few balls are larger: they would be overlooked
TUBE_SHARE = 0.006  # the same of a fibre
MUSCLE_COLOURS = np.array([[178, 88, 80], [214, 157, 76], [110, 150, 105], [120, 110, 170], [90, 150, 170]])
ATTACHMENT_COLOURS = [(0.0, 0.45, 0.70), (0.90, 0.62, 0.0), (0.80, 0.47, 0.65), (0.0, 0.62, 0.45)]


class Studio:
    """Bones of one scene, loaded once, and its cameras, which hold every shape of the given run of that scene."""

    def __init__(self, run: Run):
        self.bones = read_bones(run)
        self._scene = Scene3d(PICTURE_PIXELS, PICTURE_PIXELS)
        for name, bone in self.bones.items():
            self._scene.set_bone(name, bone.vertices_m, bone.triangles)
        snapshots = read_snapshots(run)
        shapes = [snapshot.mesh.vertices_m for snapshot in snapshots]
        joint = _joint(run, self.bones, shapes[0])
        self._overview = first_view(run, self.bones, snapshots)
        self._close_up = views.close_up(joint, self._overview.towards_eye, shapes[0])
        self._cut = sight_cut(run, self.bones, snapshots)
        self._scene.cut_bones(self._cut)

    def overview(self, snapshot: Snapshot, deepest_mm: float) -> np.ndarray:
        self._show(snapshot, depth_colours(snapshot.depth_mm, deepest_mm))
        self._scene.set_bone_opacity(1.0)
        return self._scene.picture(self._overview)

    def close_up(self, snapshot: Snapshot, deepest_mm: float) -> np.ndarray:
        """The joint seen through its bones, with the nodes inside."""
        return self._picture_inside(snapshot, deepest_mm, self._close_up)

    def inside(self, snapshot: Snapshot, deepest_mm: float, facing: np.ndarray | None) -> np.ndarray:
        """All of the muscle with its nodes inside. `facing`: see `facing_inside`."""
        view = self._overview
        eye = None if facing is None else views.level_eye(facing, view.up)
        return self._picture_inside(snapshot, deepest_mm, view if eye is None else View(view.focus_m, eye, view.up, view.half_height_m))

    def hold_close(self, snapshots: list[Snapshot]) -> None:
        """The close-up gets as large as the nodes inside of these need, and no larger than the overview."""
        view = self._close_up
        right = np.cross(view.up, view.towards_eye)
        inside = np.vstack([shot.mesh.vertices_m[shot.depth_mm > INSIDE_FROM_MM] for shot in snapshots]) - view.focus_m
        farthest = max((float(np.abs(inside @ axis).max(initial=0.0)) for axis in (right, view.up)))
        view.half_height_m = min(max(view.half_height_m, views.OVERVIEW_MARGIN * farthest), self._overview.half_height_m)

    def _picture_inside(self, snapshot: Snapshot, deepest_mm: float, view: View) -> np.ndarray:
        """Bones and muscle see-through; a node inside a bone is a ball of the colour of its depth."""
        depth, vertices = snapshot.depth_mm, snapshot.mesh.vertices_m
        inside = depth > INSIDE_FROM_MM
        self._show(snapshot, np.tile(MUSCLE_COLOUR, (len(vertices), 1)), SEE_THROUGH_MUSCLE)
        self._scene.set_bone_opacity(SEE_THROUGH_BONE)
        if inside.any():
            share = BALL_SHARE * (FEW_GROW if np.count_nonzero(inside) < FEW else 1)
            self._scene.add_points(vertices[inside], share * view.half_height_m, depth_colours(depth[inside], deepest_mm))
        return self._scene.picture(view)

    def muscles(self, snapshot: Snapshot, vertices_of_muscles: list[int], from_behind: bool) -> np.ndarray:
        """Each muscle in a colour of its own; `vertices_of_muscles` are the numbers of their vertices."""
        colours = np.vstack([np.tile(MUSCLE_COLOURS[i % len(MUSCLE_COLOURS)], (count, 1))
                             for i, count in enumerate(vertices_of_muscles)])
        self._show(snapshot, colours)
        self._scene.set_bone_opacity(1.0)
        self._scene.cut_bones(None)
        picture = self._scene.picture(self._overview.from_behind() if from_behind else self._overview)
        self._scene.cut_bones(self._cut)
        return picture

    def attachments(self, snapshot: Snapshot, groups: list[np.ndarray]) -> np.ndarray:
        """Bound nodes, one colour a group of vertex indices, seen through the muscle."""
        vertices = snapshot.mesh.vertices_m
        self._show(snapshot, np.tile(MUSCLE_COLOUR, (len(vertices), 1)), SEE_THROUGH_MUSCLE)
        self._scene.set_bone_opacity(1.0)
        for number, nodes in enumerate(groups):
            colour = ATTACHMENT_COLOURS[number % len(ATTACHMENT_COLOURS)]
            colours = np.tile(255 * np.array(colour), (len(nodes), 1))
            self._scene.add_points(vertices[nodes], BALL_SHARE * self._overview.half_height_m, colours)
        return self._scene.picture(self._overview)

    def fibres(self, snapshot: Snapshot, lines: list[np.ndarray], colours: np.ndarray) -> np.ndarray:
        """Lines of points (n, 3) as tubes, a colour each, seen through the muscle."""
        self._show(snapshot, np.tile(MUSCLE_COLOUR, (len(snapshot.mesh.vertices_m), 1)), SEE_THROUGH_SKIN)
        self._scene.set_bone_opacity(1.0)
        self._scene.add_tubes(lines, TUBE_SHARE * self._overview.half_height_m, colours)
        return self._scene.picture(self._overview)

    def _show(self, snapshot: Snapshot, colours: np.ndarray, opacity: float = 1.0) -> None:
        for name, (rotation, translation_m) in zip(self.bones, snapshot.poses):
            self._scene.pose_bone(name, rotation, translation_m)
        self._scene.clear_muscle()
        self._scene.add_muscle(snapshot.mesh.vertices_m, snapshot.mesh.triangles, colours, opacity)


def first_view(run: Run, bones: dict[str, PlyMesh], snapshots: list[Snapshot]) -> View:
    """A camera on the muscle's side that holds every one of these shapes."""
    shapes = [snapshot.mesh.vertices_m for snapshot in snapshots]
    joint = _joint(run, bones, shapes[0])
    eye = views.side_of_muscle(joint, shapes[0], np.vstack([bone.vertices_m for bone in bones.values()]))
    return views.overview(joint, eye, [part for shape in shapes for part in shapes_of_muscles(run, shape)])


def sight_cut(run: Run, bones: dict[str, PlyMesh], snapshots: list[Snapshot]) -> CutPlane:
    """Beside the muscle at rest."""
    rest_m = snapshots[0].mesh.vertices_m
    bones_m = np.vstack([bone.vertices_m for bone in bones.values()])
    return views.cut_beside(_joint(run, bones, rest_m), rest_m, bones_m)


def shapes_of_muscles(run: Run, vertices_m: np.ndarray) -> list[np.ndarray]:
    """Of all muscles' vertices those of each."""
    counts = [muscle["vertices"] for muscle in run.record.get("muscles", [])]
    return np.split(vertices_m, np.cumsum(counts)[:-1]) if counts else [vertices_m]


def facing_inside(snapshots: list[Snapshot]) -> np.ndarray | None:
    """Where most of the nodes inside look: the mean normal of the muscle at them; None where no node is inside."""
    total = np.zeros(3)
    for shot in snapshots:
        corners = shot.mesh.vertices_m[shot.mesh.triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total += normals[(shot.depth_mm > INSIDE_FROM_MM)[shot.mesh.triangles].any(axis=1)].sum(axis=0)
    return total if np.linalg.norm(total) > 0 else None


def depth_colours(depth_mm: np.ndarray, deepest_mm: float) -> np.ndarray:
    """(n, 3) bytes: the muscle's own colour outside, the depth scale inside."""
    scale = 255 * DEPTH_COLOURS(np.clip(depth_mm / deepest_mm, 0, 1))[:, :3]
    return np.where((depth_mm > INSIDE_FROM_MM)[:, None], scale, MUSCLE_COLOUR).astype(np.uint8)


def bound_nodes_by_bone(snapshot: Snapshot, bones: dict[str, PlyMesh]) -> dict[str, np.ndarray]:
    """{bone: vertex indices}: each bound node counts for the bone that is nearest to it at rest."""
    bound = np.flatnonzero(snapshot.mesh.extra["attached"])
    gaps = [
        cKDTree(bone.vertices_m @ rotation.T + translation_m).query(snapshot.mesh.vertices_m[bound])[0]
        for bone, (rotation, translation_m) in zip(bones.values(), snapshot.poses)
    ]
    nearest = np.argmin(gaps, axis=0)
    return {name: bound[nearest == index] for index, name in enumerate(bones)}


def _joint(run: Run, bones: dict[str, PlyMesh], muscle_m: np.ndarray) -> views.JointDirections:
    """From the first bone that moves; where none does, from the first bone and the muscle's own length."""
    for entry in run.record["bones"]:
        motion, moved_m = entry.get("motion", {}), bones[entry["name"]].vertices_m
        if any(motion.get("angles_rad") or []):
            return views.joint_directions(np.array(motion["axis"]), np.array(motion["centre_m"]), moved_m, muscle_m)
    length, across, _ = views.principal_axes(muscle_m)
    middle = muscle_m.mean(axis=0)
    return views.joint_directions(across, middle, middle[None] - length, muscle_m)
