"""Meshes as numpy arrays, and Medit text files (.mesh, .sol)."""
import numpy as np

WIDTHS = {"Edges": 2, "Triangles": 3, "Tetrahedra": 4}
# the lists of numbers, and what they number
LISTS = {"Corners": "Vertices", "RequiredVertices": "Vertices", "Ridges": "Edges", "RequiredEdges": "Edges",
         "RequiredTriangles": "Triangles", "RequiredTetrahedra": "Tetrahedra"}


class BadFile(Exception):
    """The file is not what Medit says it should be."""


class Mesh:
    """Vertices from 0. `cells[name]` has a row of vertex numbers per entity, `refs[name]` its reference, `lists[name]`
    the numbers (from 0) of entities that a keyword names."""

    def __init__(self, coords=None, tets=None, tet_refs=None):
        self.coords = np.zeros((0, 3)) if coords is None else np.asarray(coords, float)
        self.cells = {name: np.zeros((0, width), int) for name, width in WIDTHS.items()}
        self.refs = {name: np.zeros(0, int) for name in WIDTHS}
        self.refs["Vertices"] = np.zeros(len(self.coords), int)
        self.lists = {name: np.zeros(0, int) for name in LISTS}
        if tets is not None:
            self.cells["Tetrahedra"] = np.asarray(tets, int).reshape(-1, 4)
            self.refs["Tetrahedra"] = np.asarray(tet_refs, int)

    @property
    def tets(self):
        return self.cells["Tetrahedra"]

    @property
    def tris(self):
        return self.cells["Triangles"]

    @property
    def edges(self):
        return self.cells["Edges"]

    def set_cells(self, name, cells, refs):
        self.cells[name] = np.asarray(cells, int).reshape(-1, WIDTHS[name])
        self.refs[name] = np.asarray(refs, int)

    def counts(self):
        """Numbers of vertices and entities, for people."""
        found = {"vertices": len(self.coords)}
        found.update((name.lower(), len(self.cells[name])) for name in WIDTHS)
        return found


def numbers(words, begin, count, kind):
    """`count` numbers from the words of a file."""
    part = words[begin:begin + count]
    if len(part) < count:
        raise BadFile("the file ends within a list")
    try:
        return np.array(part).astype(float).astype(kind) if kind is int else np.array(part, dtype=float)
    except ValueError as error:
        raise BadFile(f"not a number: {error}") from error


def read_mesh(path):
    """The mesh of a .mesh file; BadFile when it is damaged."""
    with open(path, encoding="ascii") as f:
        words = f.read().split()
    mesh, at = Mesh(), 0
    while at < len(words) and words[at] != "End":
        name = words[at]
        if name in ("MeshVersionFormatted", "Dimension"):
            at += 2
            continue
        try:
            count = int(words[at + 1])
        except (IndexError, ValueError) as error:
            raise BadFile(f"no count behind {name}") from error
        at += 2
        width = {"Vertices": 4, **{n: w + 1 for n, w in WIDTHS.items()}, **dict.fromkeys(LISTS, 1)}.get(name)
        if width is None:
            raise BadFile(f"unknown keyword {name}")
        if count:
            take(mesh, name, numbers(words, at, width * count, float if name == "Vertices" else int), width)
        at += width * count
    if at >= len(words):
        raise BadFile("no End")
    return mesh


def take(mesh, name, values, width):
    """Puts the numbers of one section into the mesh."""
    if name in LISTS:
        mesh.lists[name] = values - 1
        return
    rows = values.reshape(-1, width)
    mesh.refs[name] = rows[:, -1].astype(int)
    if name == "Vertices":
        mesh.coords = np.ascontiguousarray(rows[:, :3])
    else:
        mesh.cells[name] = rows[:, :-1] - 1


def write_mesh(path, mesh):
    """Writes a .mesh file; coordinates keep every bit."""
    with open(path, "w", encoding="ascii") as f:
        f.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(mesh.coords)}\n")
        f.writelines("%r %r %r %d\n" % (*x, r) for x, r in zip(mesh.coords.tolist(), mesh.refs["Vertices"].tolist()))
        for name in WIDTHS:
            if len(mesh.cells[name]):
                f.write(f"{name}\n{len(mesh.cells[name])}\n")
                rows = np.column_stack([mesh.cells[name] + 1, mesh.refs[name]]).tolist()
                f.writelines(" ".join(map(str, row)) + "\n" for row in rows)
        for name, which in mesh.lists.items():
            if len(which):
                f.write(f"{name}\n{len(which)}\n")
                f.writelines(f"{i + 1}\n" for i in which.tolist())
        f.write("End\n")


def write_solution(path, values):
    """One scalar per vertex (array of one dimension) or one symmetric tensor (rows of six, m11 m12 m22 m13 m23 m33)."""
    rows = values.reshape(len(values), -1)
    with open(path, "w", encoding="ascii") as f:
        f.write(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(rows)}\n1 {3 if rows.shape[1] == 6 else 1}\n")
        f.writelines(" ".join(map(repr, row)) + "\n" for row in rows.tolist())
        f.write("End\n")
