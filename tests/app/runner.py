"""Runs the program and makes small meshes for the tests of the command line."""
import os
import shutil
import subprocess
import tempfile
import time
import unittest

SKEIN = os.environ["SKEIN"]
MPIRUN = [a for a in os.environ.get("SKEIN_MPIRUN", "mpirun").replace(";", " ").split(" ") if a]
LIMIT = 10  # seconds in which any error must have been told
RANKS = (1, 2)


def command(ranks, args):
    """One rank runs without mpirun, as most users do."""
    return [SKEIN, *args] if ranks == 1 else [*MPIRUN, "-n", str(ranks), SKEIN, *args]


class Result:
    def __init__(self, done, seconds):
        self.code, self.out, self.err, self.seconds = done.returncode, done.stdout, done.stderr, seconds
        # mpirun adds lines of its own when a rank ends with an error
        self.errors = [line for line in self.err.splitlines() if "skein" in line and "error" in line]


def run(ranks, *args, prefix=(), limit=60):
    begin = time.monotonic()
    done = subprocess.run([*prefix, *command(ranks, [str(a) for a in args])], capture_output=True, text=True,
                          timeout=limit, check=False)
    return Result(done, time.monotonic() - begin)


def cube(n):
    """The unit cube in n^3 cells of six tetrahedra: vertices, tetrahedra, triangles with references 1 to 6."""
    def number(i, j, k):
        return i + (n + 1) * (j + (n + 1) * k)

    verts = [(i / n, j / n, k / n) for k in range(n + 1) for j in range(n + 1) for i in range(n + 1)]
    paths = [(a, b, 3 - a - b) for a in range(3) for b in range(3) if a != b]
    tets = []
    for k in range(n):
        for j in range(n):
            for i in range(n):
                for path in paths:
                    corner = [i, j, k]
                    tet = [number(*corner)]
                    for axis in path:
                        corner[axis] += 1
                        tet.append(number(*corner))
                    if path not in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):  # odd permutations are left-handed
                        tet[2], tet[3] = tet[3], tet[2]
                    tets.append(tuple(tet))
    faces = {}
    for t in tets:
        for f in ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)):
            face = tuple(t[v] for v in f)
            key = tuple(sorted(face))
            faces[key] = None if key in faces else face

    def side(face):
        for axis in range(3):
            for value in (0, 1):
                if all(verts[v][axis] == value for v in face):
                    return 1 + 2 * axis + value
        raise AssertionError("a hull face of no side")

    return verts, tets, [(*f, side(f)) for f in faces.values() if f is not None]


def write_mesh(path, verts, tets, tris):
    with open(path, "w", encoding="ascii") as f:
        f.write("MeshVersionFormatted 2\nDimension 3\n")
        f.write(f"Vertices\n{len(verts)}\n")
        f.writelines(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in verts)
        if tets:
            f.write(f"Tetrahedra\n{len(tets)}\n")
            f.writelines(" ".join(str(v + 1) for v in t) + " 1\n" for t in tets)
        f.write(f"Triangles\n{len(tris)}\n")
        f.writelines(f"{a + 1} {b + 1} {c + 1} {ref}\n" for a, b, c, ref in tris)
        f.write("End\n")


def surface_only(verts, tris):
    """The vertices of the triangles, renumbered."""
    used = sorted({v for t in tris for v in t[:3]})
    new = {v: i for i, v in enumerate(used)}
    return [verts[v] for v in used], [(new[a], new[b], new[c], ref) for a, b, c, ref in tris]


def write_solution(path, rows):
    kind = {1: 1, 3: 2, 6: 3}[len(rows[0])]
    with open(path, "w", encoding="ascii") as f:
        f.write(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(rows)}\n1 {kind}\n")
        f.writelines(" ".join(repr(float(v)) for v in row) + "\n" for row in rows)
        f.write("End\n")


def read_rows(path, keyword, width, skip=0):
    """The rows of numbers of a section of a text file, `skip` numbers behind its count."""
    with open(path, encoding="ascii") as f:
        words = f.read().split()
    at = words.index(keyword)
    first = at + 2 + skip
    return [tuple(map(float, words[i:i + width])) for i in range(first, first + width * int(words[at + 1]), width)]


def isotropic(h):
    return (h ** -2, 0, h ** -2, 0, 0, h ** -2)


class Case(unittest.TestCase):
    """A test with a folder of its own that holds a good mesh, good.mesh, and its metric, good.sol."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="skein-app-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.verts, self.tets, self.tris = cube(3)
        self.good = self.path("good.mesh")
        write_mesh(self.good, self.verts, self.tets, self.tris)
        self.metric = self.path("good.sol")
        write_solution(self.metric, [isotropic(0.25)] * len(self.verts))

    def path(self, name):
        return os.path.join(self.folder, name)
