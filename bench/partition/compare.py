#!/usr/bin/env python3
"""Cut and time of the multilevel partitioner against gpmetis (Debian package metis). Standard library only.

    compare.py PARTITION_BENCH [--parts 8,64,256] [--keep FOLDER] [--cases NAME,...] [--repeat 3]

Cases: two cubes that gmsh makes (uniform and graded, about a million tetrahedra each), and three meshes in the folder
that the environment variable SKEIN_DATA names; what is missing is skipped with a line. All tetrahedra weigh the same, both may
be 3 % out of balance, both run on one core, and times are CPU seconds of the partitioning alone, the least of some runs of
each program: ours from the mesh to the parts, the dual graph included; gpmetis' own figure, from the ready graph.
Prints one JSON line per case and number of parts, then a table with the ratios and their geometric means.
"""
import argparse
import json
import lzma
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SIZES = {
    "uniform": "0.0161",
    "graded": "0.0024+0.0345*sqrt((x-0.3)^2+(y-0.4)^2+(z-0.5)^2)",
}
CUBE = """SetFactory("OpenCASCADE");
Box(1) = {{0, 0, 0, 1, 1, 1}};
Field[1] = MathEval;
Field[1].F = "{size}";
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm3D = 10;
Mesh.Optimize = 0;
"""
DATA = {
    "polar2-start": "ugawg-cube/polar2-start.meshb",
    "m6": "onera-m6/m6_sphere_gmsh_155k.mesh.xz",
    "ssbj": "ssbj/ssbj.meshb.xz",
}


def skip(case, why):
    print(f"skipped {case}: {why}", file=sys.stderr)


def make_cube(case, folder):
    mesh = folder / f"{case}.mesh"
    if mesh.exists():
        return mesh
    if not shutil.which("gmsh"):
        return skip(case, "gmsh is not installed")
    geometry = folder / f"{case}.geo"
    geometry.write_text(CUBE.format(size=SIZES[case]))
    subprocess.run(["gmsh", "-3", "-nt", "1", str(geometry), "-format", "mesh", "-o", str(mesh)], check=True,
                   stdout=subprocess.DEVNULL)
    return mesh


def find_data(case, folder):
    root = os.environ.get("SKEIN_DATA")
    if not root:
        return skip(case, "SKEIN_DATA is not set")
    source = Path(root) / DATA[case]
    if not source.exists():
        return skip(case, f"{source} is missing")
    if source.suffix != ".xz":
        return source
    mesh = folder / source.stem
    if not mesh.exists():
        with lzma.open(source) as packed, open(mesh, "wb") as out:
            shutil.copyfileobj(packed, out)
    return mesh


def ours(program, mesh, parts, repeat):
    rows = {}
    for _ in range(repeat):
        out = subprocess.run([program, str(mesh), "multilevel", *map(str, parts)], check=True, capture_output=True,
                             text=True)
        for row in map(json.loads, out.stdout.splitlines()):
            rows[row["parts"]] = min(row, rows.get(row["parts"], row), key=lambda r: r["cpu"])
    return rows


def metis(program, mesh, folder, case, parts, repeat):
    graph = folder / f"{case}.graph"
    if not graph.exists():
        subprocess.run([program, str(mesh), "graph", str(graph)], check=True)
    rows = {}
    for k in [k for k in parts for _ in range(repeat)]:
        out = subprocess.run(["gpmetis", "-ptype=kway", "-ufactor=30", "-nooutput", str(graph), str(k)], check=True,
                             capture_output=True, text=True).stdout
        row = {"cut": int(re.search(r"Edgecut: (\d+)", out)[1]),
               "cpu": float(re.search(r"Partitioning:\s+([\d.]+)", out)[1])}
        rows[k] = min(row, rows.get(k, row), key=lambda r: r["cpu"])
    return rows


def mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--parts", default="8,64,256")
    parser.add_argument("--keep", help="folder for meshes and graphs, used again if they are there")
    parser.add_argument("--cases", default=",".join([*DATA, *SIZES]))
    parser.add_argument("--repeat", type=int, default=3, help="runs of each program, of which the fastest counts")
    args = parser.parse_args()
    os.environ["OMP_NUM_THREADS"] = "1"
    if not shutil.which("gpmetis"):
        sys.exit("gpmetis is not installed (Debian package metis)")
    parts = [int(k) for k in args.parts.split(",")]
    folder = Path(args.keep or tempfile.mkdtemp())
    folder.mkdir(parents=True, exist_ok=True)

    table = []
    for case in args.cases.split(","):
        mesh = make_cube(case, folder) if case in SIZES else find_data(case, folder)
        if mesh is None:
            continue
        theirs = metis(args.program, mesh, folder, case, parts, args.repeat)
        for k, row in ours(args.program, mesh, parts, args.repeat).items():
            row = {"case": case, **row, "metis_cut": theirs[k]["cut"], "metis_cpu": theirs[k]["cpu"]}
            print(json.dumps(row), flush=True)
            table.append(row)
    if not args.keep:
        shutil.rmtree(folder)
    if not table:
        sys.exit("no case could be run")

    print(f"\n{'case':14} {'tets':>8} {'parts':>5} {'cut':>8} {'METIS':>8} {'ratio':>6} {'imb %':>5} {'pieces':>6} "
          f"{'cpu s':>6} {'METIS':>6} {'ratio':>6}")
    for r in table:
        print(f"{r['case']:14} {r['tets']:8} {r['parts']:5} {r['cut']:8} {r['metis_cut']:8} {r['cut'] / r['metis_cut']:6.3f} "
              f"{100 * r['imbalance']:5.2f} {r['components']:6} {r['cpu']:6.3f} {r['metis_cpu']:6.3f} "
              f"{r['cpu'] / r['metis_cpu']:6.2f}")
    cuts = [r["cut"] / r["metis_cut"] for r in table]
    times = [r["cpu"] / r["metis_cpu"] for r in table]
    total = sum(r["cpu"] for r in table) / sum(r["metis_cpu"] for r in table)
    print(f"cut ratio: geometric mean {mean(cuts):.3f}, largest {max(cuts):.3f}; time ratio: geometric mean "
          f"{mean(times):.2f}, largest {max(times):.2f}, of the sums {total:.2f}")


if __name__ == "__main__":
    main()
