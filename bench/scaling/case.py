"""The case that is scaled: a mesh of the unit cube and a metric on it, and the runs of skein adapt."""
import json
import math
import os
import subprocess
import sys
from pathlib import Path


def write_cube_surface(path, n):
    """The surface of the unit cube, n x n squares of two triangles on each side, one reference per side."""
    number, vertices, triangles = {}, [], []

    def vertex(p):
        if p not in number:
            number[p] = len(vertices) + 1
            vertices.append(p)
        return number[p]

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (0, n):
            for i in range(n):
                for j in range(n):
                    square = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0, 0, 0]
                        p[axis], p[u], p[v] = side, a, b
                        square.append(vertex(tuple(p)))
                    if side == 0:
                        square.reverse()  # outwards
                    reference = 2 * axis + (side > 0) + 1
                    triangles.append((square[0], square[1], square[2], reference))
                    triangles.append((square[0], square[2], square[3], reference))
    with open(path, "w") as out:
        out.write(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(vertices)}\n")
        out.writelines(f"{x / n!r} {y / n!r} {z / n!r} 0\n" for x, y, z in vertices)
        out.write(f"Triangles\n{len(triangles)}\n")
        out.writelines("%d %d %d %d\n" % t for t in triangles)
        out.write("End\n")


def read_vertices(path):
    """Coordinates of the vertices of a Medit text mesh."""
    with open(path) as file:
        words = iter(file.read().split())
    for word in words:
        if word == "Vertices":
            count = int(next(words))
            return [tuple(float(next(words)) for _ in range(4))[:3] for _ in range(count)]
    sys.exit(f"{path}: no vertices")


def layer_metric(x, y, z):
    """Thin layers round a spherical shell and a plane, 10:1 at most: m11 m12 m22 m13 m23 m33."""
    r = math.sqrt(x * x + y * y + z * z) + 1e-12
    m = [1 / 0.1**2, 0.0, 1 / 0.1**2, 0.0, 0.0, 1 / 0.1**2]
    for n, distance in (((x / r, y / r, z / r), r - 0.8), ((0.6, 0.0, 0.8), 0.6 * x + 0.8 * z - 0.5)):
        h = min(0.1, 0.01 + 0.4 * abs(distance))
        extra = 1 / h**2 - 1 / 0.1**2
        for k, (a, b) in enumerate(((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))):
            m[k] += extra * n[a] * n[b]
    return m


def write_metric(path, vertices):
    with open(path, "w") as out:
        out.write(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(vertices)}\n1 3\n")
        out.writelines(" ".join(f"{v:.17g}" for v in layer_metric(*p)) + "\n" for p in vertices)
        out.write("End\n")


def run_quietly(command, log):
    """Runs it; on failure prints what it said and ends."""
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    log.write("$ " + " ".join(str(c) for c in command) + "\n" + done.stdout + "\n")
    log.flush()
    if done.returncode != 0:
        sys.exit(f"{done.stdout}failed with exit code {done.returncode}: {' '.join(str(c) for c in command)}")


def make_case(skein, folder, log):
    """(name, mesh, metric). The metric is scaled with --complexity in each run."""
    data = os.environ.get("SKEIN_DATA")
    if data and (Path(data) / "ugawg-cube" / "polar2-start.meshb").exists():
        cube = Path(data) / "ugawg-cube"
        return "polar-2 on the unit cube", cube / "polar2-start.meshb", cube / "polar2-50000.solb"
    surface, mesh, text, metric = (folder / f for f in ("surface.mesh", "start.meshb", "start.mesh", "start.sol"))
    write_cube_surface(surface, 20)
    run_quietly([skein, "generate", surface, "-o", mesh], log)
    run_quietly([skein, "convert", mesh, text], log)
    write_metric(metric, read_vertices(text))
    return "layers in the unit cube", mesh, metric


def mpirun(ranks):
    """The launcher: more ranks than cores, waiting ranks give way."""
    command = ["mpirun", "-n", str(ranks), "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"]
    return command + (["--allow-run-as-root"] if os.geteuid() == 0 else [])


def measure(skein, case, kind, ranks, complexity, threads, folder, log):
    """One run of skein adapt; what of its report counts, as one flat record."""
    name, mesh, metric = case
    report, output = folder / "report.json", folder / "out.meshb"
    run_quietly(mpirun(ranks) + [skein, "adapt", mesh, "--metric", metric, "--complexity", f"{complexity:g}", "-o", output,
                                 "--report", report, "--threads", threads], log)
    run = json.loads(report.read_text())
    return {
        "case": name, "kind": kind, "ranks": ranks, "threads": threads, "complexity": complexity,
        "elements_in": run["elements_in"], "elements_out": run["elements_out"],
        "unit_share": run["length"]["unit_share"], "quality_min": run["quality"]["min"],
        "quality_mean": run["quality"]["mean"], "peak_bytes": run["peak_bytes"],
        "wall_seconds": run["seconds"]["total"], "phases": run["phases"],
    }
