#!/usr/bin/python3
"""Draws the wing-body before and after adaptation into one picture, without a screen (start it under xvfb-run).

    render.py BEFORE.meshb BEFORE.solb AFTER.meshb AFTER.solb OUT.png

Left the mesh before, right after. From above: the body and the mesh on the symmetry plane; the wing's upper side; the
tetrahedra cut by a plane across the wing. Colour: the field of field.cpp (an analytic formula, not a flow solution).
Needs Debian's python3-vtk9 and python3-numpy.
"""
import struct
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray

VERTICES, TRIANGLES, TETRAHEDRA, SOL_AT_VERTICES, END = 4, 6, 8, 62, 54
SYMMETRY, FAR_FIELD = 1, 2
CUT_AT = 6.0  # y of the lowest panels
WIDTH, TITLE, CAPTION, ROWS = 2400, 190, 56, (800, 620, 720)  # pixels
# position, focus, up and half height of the views
OVERVIEW = ((-22, 62, 52), (13.0, 4.6, 0.3), (0, 0, 1), 11.0)
WING = ((15.0, 8.2, 60), (15.0, 8.2, 0), (-1, 0, 0), 5.6)
CUT = ((16.2, -60, 0.9), (16.2, 0, 0.9), (0, 0, 1), 2.6)
RANGE = (0.55, 1.45)  # of the colours


# ---------------------------------------------------------------------------------------------------- files
def gmf_sections(path):
    """Yields (version, keyword, count, file position of what follows the count) of a GMF file."""
    data = np.memmap(path, np.uint8, mode="r")
    version = struct.unpack_from("<2i", data, 0)[1]
    position_type = "<q" if version >= 3 else "<i"
    count_type = "<q" if version >= 4 else "<i"
    at = 8
    while at and at + 4 < len(data):
        keyword = struct.unpack_from("<i", data, at)[0]
        following = struct.unpack_from(position_type, data, at + 4)[0]
        body = at + 4 + struct.calcsize(position_type)
        if keyword == END:
            return
        count = struct.unpack_from(count_type, data, body)[0] if keyword != 3 else 0
        yield data, version, keyword, count, body + struct.calcsize(count_type)
        at = following


def read_mesh(path):
    """Coordinates (n, 3), triangles (m, 4) and tetrahedra (k, 4) by vertex number from 0; triangles end with their reference."""
    found = {}
    for data, version, keyword, count, at in gmf_sections(path):
        real, whole = ("<f8" if version >= 2 else "<f4"), ("<i8" if version >= 4 else "<i4")
        if keyword == VERTICES:
            row = np.dtype([("x", real, 3), ("ref", whole)])
            found["coords"] = np.frombuffer(data, row, count, at)["x"].astype(float)
        elif keyword in (TRIANGLES, TETRAHEDRA):
            width = 4 if keyword == TRIANGLES else 5
            rows = np.frombuffer(data, whole, count * width, at).reshape(count, width).astype(np.int64)
            rows[:, : width - 1] -= 1
            found[keyword] = rows
    return found["coords"], found[TRIANGLES], found[TETRAHEDRA][:, :4]


def read_scalar(path):
    for data, version, keyword, count, at in gmf_sections(path):
        if keyword == SOL_AT_VERTICES:
            kinds = struct.unpack_from("<i", data, at)[0]
            return np.frombuffer(data, "<f8" if version >= 2 else "<f4", count, at + 4 + 4 * kinds).astype(float)
    raise SystemExit(f"{path}: no solution at vertices")


# ---------------------------------------------------------------------------------------------------- geometry
def cut(coords, scalar, tets, at):
    """The tetrahedra cut by the plane y = at, as triangles and quadrilaterals."""
    y = coords[tets, 1]
    tets = tets[(y.min(axis=1) <= at) & (y.max(axis=1) > at)]
    used, local = np.unique(tets, return_inverse=True)
    rows = np.column_stack([np.full(len(tets), 4), local.reshape(-1, 4)]).astype(np.int64)
    cells = vtk.vtkCellArray()
    cells.SetCells(len(tets), numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
    grid = vtk.vtkUnstructuredGrid()
    grid.SetPoints(points_of(coords[used]))
    grid.SetCells(vtk.VTK_TETRA, cells)
    grid.GetPointData().SetScalars(numpy_to_vtk(scalar[used], deep=True))
    plane = vtk.vtkPlane()
    plane.SetOrigin(0, at, 0)
    plane.SetNormal(0, 1, 0)
    cutter = vtk.vtkCutter()
    cutter.SetInputData(grid)
    cutter.SetCutFunction(plane)
    cutter.GenerateTrianglesOff()
    cutter.Update()
    return cutter.GetOutput()


def points_of(coords):
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(coords, deep=True))
    return points


def poly_data(coords, scalar, faces):
    used, local = np.unique(faces, return_inverse=True)
    cells = vtk.vtkCellArray()
    rows = np.column_stack([np.full(len(faces), 3), local.reshape(-1, 3)]).astype(np.int64)
    cells.SetCells(len(faces), numpy_to_vtkIdTypeArray(rows.ravel(), deep=True))
    data = vtk.vtkPolyData()
    data.SetPoints(points_of(coords[used]))
    data.SetPolys(cells)
    values = numpy_to_vtk(scalar[used], deep=True)
    values.SetName("field")
    data.GetPointData().SetScalars(values)
    return data


# ---------------------------------------------------------------------------------------------------- picture
def colours():
    function = vtk.vtkColorTransferFunction()
    function.SetColorSpaceToLab()
    for t, rgb in zip(
        np.linspace(*RANGE, 7),
        [
            (0.19, 0.21, 0.58),
            (0.27, 0.46, 0.71),
            (0.62, 0.81, 0.89),
            (0.97, 0.96, 0.84),
            (0.99, 0.75, 0.44),
            (0.90, 0.38, 0.24),
            (0.62, 0.04, 0.15),
        ],
    ):
        function.AddRGBPoint(t, *rgb)
    return function


def actor(data, table, edge_width, edge_grey, ambient):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetLookupTable(table)
    mapper.SetScalarRange(*RANGE)
    mapper.InterpolateScalarsBeforeMappingOn()
    shown = vtk.vtkActor()
    shown.SetMapper(mapper)
    look = shown.GetProperty()
    look.SetInterpolationToFlat()
    look.SetAmbient(ambient)
    look.SetDiffuse(1 - ambient)
    look.EdgeVisibilityOn()
    look.SetEdgeColor(edge_grey, edge_grey, edge_grey)
    look.SetLineWidth(edge_width)
    return shown


def text(words, size, at, bold=False, centred=True):
    shown = vtk.vtkTextActor()
    shown.SetInput(words)
    look = shown.GetTextProperty()
    look.SetFontSize(size)
    look.SetColor(0.1, 0.1, 0.12)
    look.SetBold(bold)
    look.SetFontFamilyToArial()
    if centred:
        look.SetJustificationToCentered()
    look.SetVerticalJustificationToCentered()
    shown.GetPositionCoordinate().SetCoordinateSystemToNormalizedViewport()
    shown.SetPosition(*at)
    return shown


class Page:
    """The picture, filled from above with rows of two panels, each under its caption."""

    def __init__(self):
        self.height = TITLE + sum(ROWS) + CAPTION * len(ROWS)
        self.top = 0
        self.window = vtk.vtkRenderWindow()
        self.window.SetOffScreenRendering(1)
        self.window.SetMultiSamples(8)
        self.window.SetSize(WIDTH, self.height)
        self.place(0, 1, self.height)  # white behind everything

    def place(self, x0, x1, height):
        """A white renderer between x0 and x1 (of 0 to 1), `height` pixels high, at the current row."""
        renderer = vtk.vtkRenderer()
        renderer.SetViewport(x0, 1 - (self.top + height) / self.height, x1, 1 - self.top / self.height)
        renderer.SetBackground(1, 1, 1)
        self.window.AddRenderer(renderer)
        return renderer

    def row(self, panels, camera, height):
        """panels: (caption, actor) of the left and the right."""
        for column, (caption, shown) in enumerate(panels):
            strip = self.place(0.5 * column, 0.5 * (column + 1), CAPTION)
            strip.AddActor2D(text(caption, 32, (0.02, 0.42), centred=False))
        self.top += CAPTION
        for column, (caption, shown) in enumerate(panels):
            renderer = self.place(0.004 + 0.5 * column, 0.496 + 0.5 * column, height)
            renderer.AddActor(shown)
            position, focus, up, scale = camera
            view = renderer.GetActiveCamera()
            view.SetPosition(*position)
            view.SetFocalPoint(*focus)
            view.SetViewUp(*up)
            view.ParallelProjectionOn()
            view.SetParallelScale(scale)
            renderer.ResetCameraClippingRange()
        self.top += height

    def write(self, path):
        self.window.Render()
        image = vtk.vtkWindowToImageFilter()
        image.SetInput(self.window)
        image.ReadFrontBufferOff()
        writer = vtk.vtkPNGWriter()
        writer.SetFileName(path)
        writer.SetInputConnection(image.GetOutputPort())
        writer.Write()


def title(page, table):
    renderer = page.place(0, 1, TITLE)
    page.top += TITLE
    renderer.AddActor2D(text("Wing-body half model: mesh before and after adaptation", 48, (0.01, 0.66), True, False))
    remark = "colour: analytic, Mach-like field with a bow shock, a lambda shock and a wake (not a flow solution)"
    renderer.AddActor2D(text(remark, 29, (0.01, 0.26), False, False))
    bar = vtk.vtkScalarBarActor()
    bar.SetLookupTable(table)
    bar.SetOrientationToHorizontal()
    bar.SetNumberOfLabels(4)
    bar.SetLabelFormat("%.2f")
    bar.SetTitle("")
    bar.UnconstrainedFontSizeOn()
    labels = bar.GetLabelTextProperty()
    labels.SetColor(0.1, 0.1, 0.12)
    labels.SetFontSize(26)
    labels.ShadowOff()
    labels.ItalicOff()
    bar.SetPosition(0.70, 0.12)
    bar.SetPosition2(0.28, 0.76)
    renderer.AddActor2D(bar)


def thousands(n):
    return f"{n:,}".replace(",", " ")


def draw(mesh_path, field_path, table):
    """The three actors of one mesh, and its count of tetrahedra and vertices."""
    coords, triangles, tets = read_mesh(mesh_path)
    scalar = read_scalar(field_path)
    near = np.linalg.norm(coords[triangles[:, :3]].mean(axis=1) - (12, 0, 0), axis=1) < 60
    surface = triangles[near & (triangles[:, 3] != FAR_FIELD)]
    body = surface[surface[:, 3] != SYMMETRY]
    line = 1.0 if len(tets) < 200000 else 0.7
    shown = (
        actor(poly_data(coords, scalar, surface[:, :3]), table, line, 0.25, 0.6),
        actor(poly_data(coords, scalar, body[:, :3]), table, line, 0.25, 0.7),
        actor(cut(coords, scalar, tets, CUT_AT), table, line, 0.25, 1.0),
    )
    return shown, f"{thousands(len(tets))} tetrahedra, {thousands(len(coords))} vertices"


def main():
    if len(sys.argv) != 6:
        raise SystemExit(__doc__)
    table = colours()
    before, before_size = draw(sys.argv[1], sys.argv[2], table)
    after, after_size = draw(sys.argv[3], sys.argv[4], table)
    captions = (
        (f"before: {before_size}", f"after: {after_size}"),
        ("before: the wing from above", "after: the wing from above"),
        (f"before: the tetrahedra cut at y = {CUT_AT:g}", f"after: the tetrahedra cut at y = {CUT_AT:g}"),
    )
    page = Page()
    title(page, table)
    for row, (camera, height) in enumerate(zip((OVERVIEW, WING, CUT), ROWS)):
        page.row(((captions[row][0], before[row]), (captions[row][1], after[row])), camera, height)
    page.write(sys.argv[5])
    print(f"before: {before_size}\nafter: {after_size}")


if __name__ == "__main__":
    main()
