"""Is a mesh a mesh? Each fault is a pair: its kind, and a sentence with the first entity (numbers from 1, as in files)."""
from fractions import Fraction

import numpy as np

import medit
import topology

# A determinant above this part of the sum of its terms' sizes is positive whatever the rounding.
SURE = 4e-15


def fault(kind, which, what):
    return kind, f"{len(which)} {what}, first {int(which[0]) + 1}"


def references(mesh):
    """Faults that make any further look impossible: numbers out of range, coordinates that are not finite."""
    found = []
    bad = np.flatnonzero(~np.isfinite(mesh.coords).all(axis=1))
    if len(bad):
        found.append(fault("not-finite", bad, "vertices are not finite"))
    for name, cells in mesh.cells.items():
        bad = np.flatnonzero(((cells < 0) | (cells >= len(mesh.coords))).any(axis=1))
        if len(bad):
            found.append(fault("out-of-range", bad, f"{name} with vertex numbers out of range"))
            continue
        ordered = np.sort(cells, axis=1)
        bad = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
        if len(bad):
            found.append(fault("repeated-vertex", bad, f"{name} with a vertex twice"))
    for name, named in medit.LISTS.items():
        size = len(mesh.coords) if named == "Vertices" else len(mesh.cells[named])
        bad = np.flatnonzero((mesh.lists[name] < 0) | (mesh.lists[name] >= size))
        if len(bad):
            found.append(fault("out-of-range", bad, f"numbers of {name} out of range"))
    return found


def exact_volume6(coords, tet):
    a, b, c, d = ([Fraction(float(v)) for v in coords[i]] for i in tet)
    p, q, r = ([x - y for x, y in zip(v, a)] for v in (b, c, d))
    return (p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0])
            + p[2] * (q[0] * r[1] - q[1] * r[0]))


def not_positive(mesh):
    """Tetrahedra whose volume is not greater than 0; rounding decides nothing."""
    a = mesh.coords[mesh.tets[:, 0]]
    b, c, d = (mesh.coords[mesh.tets[:, i]] - a for i in (1, 2, 3))
    det = np.einsum("ij,ij->i", np.cross(b, c), d)
    size = np.einsum("ij,ij->i", np.abs(b)[:, [1, 2, 0]] * np.abs(c)[:, [2, 0, 1]]
                     + np.abs(b)[:, [2, 0, 1]] * np.abs(c)[:, [1, 2, 0]], np.abs(d))
    # The differences from vertex a are rounded, too: relatively, unless they are 0.
    doubt = np.flatnonzero(np.abs(det) <= SURE * size)
    bad = list(np.flatnonzero(det < -SURE * size))
    bad += [t for t in doubt if exact_volume6(mesh.coords, mesh.tets[t]) <= 0]
    return np.sort(np.array(bad, int))


def doubles(cells):
    """Cells that are there twice."""
    key = topology.keys(cells) if cells.shape[1] < 4 else None
    if key is None:
        ordered = np.sort(cells, axis=1)
        _, key = np.unique(ordered, axis=0, return_inverse=True)
    order = np.argsort(key, kind="stable")
    return np.sort(order[1:][key[order][1:] == key[order][:-1]])


def same_side(faces):
    """Faces whose two tetrahedra see them the same way round."""
    two = np.flatnonzero(faces.count == 2)
    one, other = faces.sides[faces.first[two]], faces.sides[faces.second[two]]
    at = np.argmax(other == one[:, :1], axis=1)
    return two[other[np.arange(len(two)), (at + 1) % 3] == one[:, 1]]


def whole(mesh, faces):
    """Faults of a mesh whose numbers are in range."""
    found = []

    def tell(kind, which, what):
        if len(which):
            found.append(fault(kind, which, what))

    tell("no-volume", not_positive(mesh), "tetrahedra without positive volume")
    tell("face-of-three", faces.first[faces.count > 2] // 4, "faces of more than two tetrahedra")
    tell("same-side", faces.first[same_side(faces)] // 4, "faces with both tetrahedra on one side")
    used = np.zeros(len(mesh.coords), bool)
    used[mesh.tets] = True
    tell("unused-vertex", np.flatnonzero(~used), "vertices of no tetrahedron")
    for name, cells in mesh.cells.items():
        tell("twice", doubles(cells), f"{name} twice")
    tell("no-face", np.flatnonzero(faces.find(mesh.tris) < 0), "triangles that are no face")
    all_edges = np.unique(topology.keys(mesh.tets[:, topology.TET_EDGES].reshape(-1, 2)))
    tell("no-edge", np.flatnonzero(~np.isin(topology.keys(mesh.edges), all_edges)), "edges of no tetrahedron")
    return found
