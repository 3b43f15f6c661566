"""Off-screen pictures of a muscle on its bones, drawn with VTK. Needs a display."""

from dataclasses import dataclass

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

BONE_COLOUR = (0.93, 0.89, 0.78)
FEATURE_ANGLE_DEG = 60.0
MAXIMUM_PEELS = 8


@dataclass
class View:
    """An orthographic camera; lengths in metres."""

    focus_m: np.ndarray
    towards_eye: np.ndarray  # unit vector from the focus to the eye
    up: np.ndarray
    half_height_m: float

    def from_behind(self) -> "View":
        return View(self.focus_m, -self.towards_eye, self.up, self.half_height_m)


@dataclass
class CutPlane:
    """Bones are drawn only where (x - origin) . normal >= 0."""

    origin_m: np.ndarray
    normal: np.ndarray


def poly_data(vertices_m: np.ndarray, triangles: np.ndarray) -> vtk.vtkPolyData:
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(vertices_m, dtype=np.float64), deep=True))
    offsets = np.arange(0, 3 * len(triangles) + 1, 3, dtype=np.int64)
    corners = np.ascontiguousarray(triangles, dtype=np.int64).ravel()
    cells = vtk.vtkCellArray()
    cells.SetData(numpy_to_vtk(offsets, deep=True, array_type=vtk.VTK_ID_TYPE),
                  numpy_to_vtk(corners, deep=True, array_type=vtk.VTK_ID_TYPE))
    data = vtk.vtkPolyData()
    data.SetPoints(points)
    data.SetPolys(cells)
    return data


def with_normals(data: vtk.vtkPolyData) -> vtk.vtkPolyData:
    normals = vtk.vtkPolyDataNormals()
    normals.SetInputData(data)
    normals.SetFeatureAngle(FEATURE_ANGLE_DEG)
    normals.Update()
    return normals.GetOutput()


class Scene3d:
    """One window for all pictures of a run's bones; bones stay loaded and only change their pose."""

    def __init__(self, width: int, height: int):
        self._renderer = vtk.vtkRenderer()
        self._renderer.SetBackground(1, 1, 1)
        self._renderer.UseFXAAOn()
        self._renderer.SetMaximumNumberOfPeels(MAXIMUM_PEELS)
        self._window = vtk.vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)  # depth peeling, which sorts see-through surfaces, can't be multi-sampled
        self._window.SetSize(width, height)
        self._window.AddRenderer(self._renderer)
        self._bones: dict[str, vtk.vtkActor] = {}
        self._temporary: list[vtk.vtkActor] = []
        self._add_lights()

    def set_bone(self, name: str, vertices_m: np.ndarray, triangles: np.ndarray, colours: np.ndarray | None = None,
                 opacity: float = 1.0) -> None:
        """In the place of one of this name. colours (n, 3) in 0..255, one a vertex; that of bone unless told."""
        data = poly_data(vertices_m, triangles)
        if colours is not None:
            data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(colours, dtype=np.uint8), deep=True))
        actor = _surface_actor(with_normals(data))
        actor.GetProperty().SetColor(*BONE_COLOUR)
        actor.GetProperty().SetOpacity(opacity)
        if name in self._bones:
            self._renderer.RemoveActor(self._bones[name])
        self._renderer.AddActor(actor)
        self._bones[name] = actor

    def pose_bone(self, name: str, rotation: np.ndarray, translation_m: np.ndarray) -> None:
        matrix = vtk.vtkMatrix4x4()
        for row in range(3):
            for column in range(3):
                matrix.SetElement(row, column, float(rotation[row, column]))
            matrix.SetElement(row, 3, float(translation_m[row]))
        self._bones[name].SetUserMatrix(matrix)

    def set_bone_opacity(self, opacity: float) -> None:
        for actor in self._bones.values():
            actor.GetProperty().SetOpacity(opacity)

    def cut_bones(self, plane: CutPlane | None) -> None:
        for actor in self._bones.values():
            mapper = actor.GetMapper()
            mapper.RemoveAllClippingPlanes()
            if plane is not None:
                clip = vtk.vtkPlane()
                clip.SetOrigin(*plane.origin_m)
                clip.SetNormal(*plane.normal)
                mapper.AddClippingPlane(clip)

    def add_muscle(self, vertices_m: np.ndarray, triangles: np.ndarray, colours: np.ndarray, opacity=1.0) -> None:
        """colours (n, 3) in 0..255, one a vertex; stays until clear_muscle."""
        data = poly_data(vertices_m, triangles)
        scalars = numpy_to_vtk(np.ascontiguousarray(colours, dtype=np.uint8), deep=True)
        data.GetPointData().SetScalars(scalars)
        actor = _surface_actor(with_normals(data))
        actor.GetProperty().SetOpacity(opacity)
        self._add_temporary(actor)

    def add_points(self, points_m: np.ndarray, radius_m: float, colours: np.ndarray) -> None:
        """Balls, each of its colour (n, 3) in 0..255; stay until clear_muscle."""
        ball = vtk.vtkSphereSource()
        ball.SetRadius(radius_m)
        ball.SetThetaResolution(10)
        ball.SetPhiResolution(8)
        glyphs = vtk.vtkGlyph3DMapper()
        data = poly_data(points_m, np.empty((0, 3)))
        data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(colours, dtype=np.uint8), deep=True))
        glyphs.SetInputData(data)
        glyphs.SetSourceConnection(ball.GetOutputPort())
        glyphs.ScalingOff()
        actor = vtk.vtkActor()
        actor.SetMapper(glyphs)
        self._add_temporary(actor)

    def add_tubes(self, lines: list[np.ndarray], radius_m: float, colours: np.ndarray) -> None:
        """A tube along each line of points (n, 3), of a colour of its own (0..255); stay until clear_muscle."""
        data = vtk.vtkPolyData()
        points, cells = vtk.vtkPoints(), vtk.vtkCellArray()
        points.SetData(numpy_to_vtk(np.ascontiguousarray(np.vstack(lines), dtype=np.float64), deep=True))
        first = 0
        for line in lines:
            cells.InsertNextCell(len(line), range(first, first + len(line)))
            first += len(line)
        data.SetPoints(points)
        data.SetLines(cells)
        data.GetCellData().SetScalars(numpy_to_vtk(np.ascontiguousarray(colours, dtype=np.uint8), deep=True))
        tube = vtk.vtkTubeFilter()
        tube.SetInputData(data)
        tube.SetRadius(radius_m)
        tube.SetNumberOfSides(8)
        tube.CappingOn()
        tube.Update()
        self._add_temporary(_surface_actor(tube.GetOutput()))

    def clear_muscle(self) -> None:
        for actor in self._temporary:
            self._renderer.RemoveActor(actor)
        self._temporary.clear()

    def picture(self, view: View) -> np.ndarray:
        """(height, width, 3) bytes."""
        camera = self._renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(*view.focus_m)
        camera.SetPosition(*(view.focus_m + 2.0 * view.towards_eye))
        camera.SetViewUp(*view.up)
        camera.SetParallelScale(view.half_height_m)
        self._renderer.ResetCameraClippingRange()
        self._renderer.SetUseDepthPeeling(self._see_through())
        self._window.Render()
        grab = vtk.vtkWindowToImageFilter()
        grab.SetInput(self._window)
        grab.ReadFrontBufferOff()
        grab.ShouldRerenderOff()  # it would draw all again
        grab.Update()
        image = grab.GetOutput()
        width, height, _ = image.GetDimensions()
        pixels = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)
        return pixels[::-1, :, :3].copy()

    def _see_through(self) -> bool:
        actors = [*self._bones.values(), *self._temporary]
        return any(actor.GetProperty().GetOpacity() < 1.0 for actor in actors)

    def _add_temporary(self, actor: vtk.vtkActor) -> None:
        self._renderer.AddActor(actor)
        self._temporary.append(actor)

    def _add_lights(self) -> None:
        kit = vtk.vtkLightKit()
        kit.SetKeyLightAngle(35, 25)
        kit.SetKeyToFillRatio(2.5)
        kit.AddLightsToRenderer(self._renderer)


def _surface_actor(data: vtk.vtkPolyData) -> vtk.vtkActor:
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    surface = actor.GetProperty()
    surface.SetAmbient(0.12)
    surface.SetDiffuse(0.88)
    surface.SetSpecular(0.08)
    surface.SetSpecularPower(12)
    return actor
