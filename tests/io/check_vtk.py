"""Opens a .vtu or .pvtu with VTK and compares it with what it must be.

    check_vtk.py FILE POINTS TETS TRIANGLES VOLUME AREA REFSUM [NAME COMPONENT LOW HIGH]...

A name that begins with "cell:" is that of an array of the cells.

Prints one line for each difference; the exit code is their number.
"""
import sys

from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader

TRIANGLE, TETRA = 5, 10


def read(path):
    reader = vtkXMLPUnstructuredGridReader() if path.endswith(".pvtu") else vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def sizes(grid):
    """The sums of volumes, areas and references over the cells."""
    measure = vtkCellSizeFilter()
    measure.SetInputData(grid)
    measure.Update()
    data = measure.GetOutput().GetCellData()
    cells = range(grid.GetNumberOfCells())
    return [sum(data.GetArray(name).GetTuple1(i) for i in cells) for name in ("Volume", "Area", "ref")]


def compare(path, wanted):
    grid = read(path)
    kinds = [grid.GetCellType(i) for i in range(grid.GetNumberOfCells())]
    found = {"points": grid.GetNumberOfPoints(), "tetrahedra": kinds.count(TETRA), "triangles": kinds.count(TRIANGLE)}
    found["volume"], found["area"], found["references"] = sizes(grid)
    pairs = [(name, found[name], float(value)) for name, value in zip(found, wanted)]
    for i in range(6, len(wanted), 4):
        name, component, low, high = wanted[i : i + 4]
        data = grid.GetCellData() if name.startswith("cell:") else grid.GetPointData()
        array = data.GetArray(name.removeprefix("cell:"))
        if array is None:
            pairs.append((name, float("nan"), 0.0))
            continue
        got = array.GetRange(int(component))
        pairs += [(name + " least", got[0], float(low)), (name + " largest", got[1], float(high))]
    return [p for p in pairs if not abs(p[1] - p[2]) <= 1e-12 * abs(p[2])]


differences = compare(sys.argv[1], sys.argv[2:])
for name, got, want in differences:
    print(f"{sys.argv[1]}: {name} is {got!r}, but must be {want!r}")
sys.exit(len(differences))
