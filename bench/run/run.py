#!/usr/bin/env python3
"""The kernel's operations and whole cases through the skein program, beside TetGen and Gmsh's HXT on the same machine.
Standard library only.

    bench/run/run.py [--build DIR] [--no-build] [--repeat N] [--threads 1,2] [--quick] [--json FILE] [--keep DIR]

Cases: uniform refinement of a cube, anisotropic adaptation to a layer along a cylinder, uniform coarsening. The rate is
tetrahedra of the result (for coarsening: of the input) per second of the adaptation itself, without reading and
writing, as the report of the run has it. On a machine that does other things, too, look at the rate per CPU second
(of all threads; of HXT and TetGen that of the whole volume meshing) instead of the wall clock. Yardsticks, each with its own times, without its files: `tetgen -pq1.4a...`
and `gmsh -algo hxt` (tEmptyMesh + tRefine + tOptimize). Each is run N times, the fastest counts. One JSON line per
result, then a table with the ratio to HXT. gmsh is needed for the cubes; without tetgen that line is missing.
"""
import argparse
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BOX = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 1, 1};\n'
SIDES = ["0 1 2 3", "4 5 6 7", "0 1 5 4", "1 2 6 5", "2 3 7 6", "3 0 4 7"]
CORNERS = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1", "1 1 1", "0 1 1"]


def call(command, cwd):
    done = subprocess.run([str(c) for c in command], cwd=cwd, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}\nended with {done.returncode}")
    return done.stdout


def children_cpu():
    """CPU seconds of all child processes that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


# --- files --------------------------------------------------------------------------------------------------------


def read_vertices(path):
    """Coordinates of an ASCII .mesh file."""
    with open(path) as f:
        words = (w for line in f for w in line.split("#")[0].split())
        for word in words:
            if word == "Vertices":
                n = int(next(words))
                return [(float(next(words)), float(next(words)), float(next(words)), next(words))[:3] for _ in range(n)]
    sys.exit(f"{path}: no vertices")


def write_sol(path, rows):
    width = len(rows[0])
    kind = {1: 1, 6: 3}[width]
    with open(path, "w") as f:
        f.write(f"MeshVersionFormatted 2\n\nDimension 3\n\nSolAtVertices\n{len(rows)}\n1 {kind}\n")
        f.writelines(" ".join(f"{x:.12g}" for x in row) + "\n" for row in rows)
        f.write("\nEnd\n")


def layer_metric(x, y, _z):
    """Thin across the cylinder of radius 1/2 about the z axis, wide along it; Medit order."""
    r = math.hypot(x, y)
    thin = 1 / (0.008 + 0.2 * abs(r - 0.5)) ** 2
    wide = 1 / 0.12 ** 2
    c, s = (x / r, y / r) if r > 1e-9 else (1.0, 0.0)
    if r <= 1e-9:
        thin = wide
    return (thin * c * c + wide * s * s, (thin - wide) * c * s, thin * s * s + wide * c * c, 0.0, 0.0, wide)


def gmsh_cube(work, h, name):
    (work / "box.geo").write_text(BOX)
    call(["gmsh", "-3", "-nt", "1", "-clmax", h, "-clmin", h, "box.geo", "-format", "mesh", "-o", name], work)
    return work / name


# --- what is measured ---------------------------------------------------------------------------------------------


class Bench:
    def __init__(self, args, work):
        self.args, self.work = args, work
        self.skein = Path(args.build) / "bin" / "skein"
        self.results, self.operations = [], []
        self.out = open(args.json, "w") if args.json else None

    def record(self, **result):
        result["load"] = round(os.getloadavg()[0], 2)
        self.results.append(result)
        self.write(result)

    def write(self, result):
        line = json.dumps(result)
        print(line, flush=True)
        if self.out:
            self.out.write(line + "\n")

    def kernel(self):
        """Nanoseconds and cycles of single operations (bench/kernel)."""
        log = call([Path(self.args.build) / "bin" / "kernel_bench", f"--benchmark_min_time={0.05 if self.args.quick else 0.5}"],
                   self.work)
        self.operations = [json.loads(line) for line in log.splitlines() if line.startswith("{")]
        for operation in self.operations:
            self.write(operation)

    def adapt(self, mesh, out, threads, *options):
        report = self.work / "report.json"
        call([self.skein, "adapt", mesh, "-o", out, "--threads", threads, "--report", report, "--quiet", *options], self.work)
        return json.loads(report.read_text())

    def case(self, name, mesh, out, options, rate_of):
        for threads in self.args.threads:
            runs = [self.adapt(mesh, out, threads, *options) for _ in range(self.args.repeat)]
            r = min(runs, key=lambda run: run["seconds"]["adapt"])
            seconds = r["seconds"]["adapt"]
            cpu = sum(p["cpu"]["mean"] for p in r["phases"] if p["name"].startswith(("growth", "round", "balance", "reconcile")))
            self.record(case=name, program="skein", threads=threads, elements_in=r["elements_in"],
                        elements=r["elements_out"], seconds=round(seconds, 3),
                        seconds_total=round(r["seconds"]["total"], 3), tets_per_second=round(r[rate_of] / seconds),
                        cpu_seconds=round(cpu, 3), tets_per_cpu_second=round(r[rate_of] / cpu),
                        unit_share=r["length"]["unit_share"], quality_min=r["quality"]["min"],
                        quality_mean=r["quality"]["mean"], peak_bytes=max(r["peak_bytes"]))

    def uniform(self):
        h = 0.05 if self.args.quick else 0.022
        start = gmsh_cube(self.work, 0.08 if self.args.quick else 0.05, "cube.mesh")
        write_sol(self.work / "fine.sol", [(h,)] * len(read_vertices(start)))
        fine = self.work / "fine.mesh"
        self.case("uniform", start, fine, ["--size", "fine.sol"], "elements_out")
        return start, fine

    def layer(self, start):
        """First to the metric as it is, then to many more elements, as a solver's loop does."""
        near = start
        for step in range(2):
            write_sol(self.work / "layer.sol", [layer_metric(*x) for x in read_vertices(near)])
            self.adapt(near, f"layer{step}.mesh", 1, "--metric", "layer.sol")
            near = self.work / f"layer{step}.mesh"
        write_sol(self.work / "layer.sol", [layer_metric(*x) for x in read_vertices(near)])
        complexity = 4000 if self.args.quick else 50000
        self.case("layer", near, self.work / "layer.meshb", ["--metric", "layer.sol", "--complexity", complexity],
                  "elements_out")

    def coarsening(self, fine):
        h = 0.1 if self.args.quick else 0.05
        write_sol(self.work / "coarse.sol", [(h,)] * len(read_vertices(fine)))
        self.case("coarsening", fine, self.work / "coarse.meshb", ["--size", "coarse.sol"], "elements_in")

    def tetgen(self):
        if shutil.which("tetgen") is None:
            return
        text = ["8 3 0 0"] + [f"{i} {c}" for i, c in enumerate(CORNERS)] + ["6 0"]
        for side in SIDES:
            text += ["1 0", "4 " + side]
        (self.work / "cube.poly").write_text("\n".join(text + ["0", "0", ""]))
        option = "-pq1.4a1e-4" if self.args.quick else "-pq1.4a1e-6"
        best = None
        for _ in range(self.args.repeat):
            before = children_cpu()
            log = call(["tetgen", option, "-NEF", "cube.poly"], self.work)
            cpu = children_cpu() - before
            seconds = float(re.search(r"Total running seconds:\s*([\d.e+-]+)", log)[1])
            tets = int(re.search(r"Mesh tetrahedra:\s*(\d+)", log)[1])
            best = min(best or (seconds, tets, cpu), (seconds, tets, cpu))
        self.record(case="generation", program=f"tetgen {option}", threads=1, elements=best[1],
                    seconds=round(best[0], 3), tets_per_second=round(best[1] / best[0]),
                    cpu_seconds=round(best[2], 3), tets_per_cpu_second=round(best[1] / best[2]))

    def hxt(self):
        (self.work / "box.geo").write_text(BOX)
        h = 0.04 if self.args.quick else 0.0115
        best = None
        for _ in range(self.args.repeat):
            log = call(["gmsh", "-3", "-algo", "hxt", "-nt", "1", "-clmax", h, "-clmin", h, "box.geo", "-format", "msh",
                        "-bin", "-o", "hxt.msh"], self.work)
            seconds = sum(float(re.search(name + r"\s*=\s*([\d.]+)", log)[1])
                          for name in ("tEmptyMesh", "tRefine", "tOptimize"))
            tets = int(re.search(r"Final tet. mesh contains (\d+) tetrahedra", log)[1])
            cpu = float(re.search(r"Done meshing 3D \(Wall [\d.e+-]+s, CPU ([\d.e+-]+)s\)", log)[1])
            best = min(best or (seconds, tets, cpu), (seconds, tets, cpu))
        self.record(case="generation", program="gmsh hxt", threads=1, elements=best[1], seconds=round(best[0], 3),
                    tets_per_second=round(best[1] / best[0]), cpu_seconds=round(best[2], 3),
                    tets_per_cpu_second=round(best[1] / best[2]))

    def table(self):
        hxt = next(r for r in self.results if r["program"] == "gmsh hxt")
        print(f"\n{'case':12} {'program':20} {'threads':>7} {'tets':>10} {'seconds':>8} {'tets/s':>9} {'/ HXT':>6} "
              f"{'CPU s':>8} {'tets/CPU s':>10} {'/ HXT':>6} {'unit %':>6} {'Q min':>6} {'Q mean':>6}")
        for r in self.results:
            quality = ""
            if "unit_share" in r:
                quality = f" {r['unit_share']:6.2f} {r['quality_min']:6.3f} {r['quality_mean']:6.3f}"
            print(f"{r['case']:12} {r['program']:20} {r['threads']:7} {r['elements']:10,} {r['seconds']:8.2f} "
                  f"{r['tets_per_second']:9,} {r['tets_per_second'] / hxt['tets_per_second']:6.3f} "
                  f"{r['cpu_seconds']:8.2f} {r['tets_per_cpu_second']:10,} "
                  f"{r['tets_per_cpu_second'] / hxt['tets_per_cpu_second']:6.3f}{quality}")
        print("tets/s: of the result (coarsening: of the input) per second of the adaptation alone")
        print(f"\n{'operation':28} {'ns':>9} {'cycles':>9} {'cycles/try':>10}")
        for r in self.operations:
            kind = "op" if "ns_per_op" in r else "done"
            if f"ns_per_{kind}" not in r:
                continue
            tries = f" {r['cycles_per_try']:10,.0f}" if "cycles_per_try" in r else ""
            print(f"{r['benchmark'].split('/')[0]:28} {r[f'ns_per_{kind}']:9,.1f} {r[f'cycles_per_{kind}']:9,.0f}{tries}")


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--build", default=str(ROOT / "build" / "release"), help="build folder (build/release)")
    p.add_argument("--no-build", action="store_true", help="take the program that is there")
    p.add_argument("--repeat", type=int, default=1, help="runs of each case; the fastest counts")
    p.add_argument("--threads", default="1,2", type=lambda s: [int(t) for t in s.split(",")])
    p.add_argument("--quick", action="store_true", help="small meshes, to try the script")
    p.add_argument("--json", help="write the JSON lines to this file, too")
    p.add_argument("--keep", help="work in this folder and keep it")
    args = p.parse_args()
    if shutil.which("gmsh") is None:
        sys.exit("gmsh is needed for the cubes and as yardstick; install it")
    if not args.no_build:
        call(["cmake", "-S", ROOT, "-B", args.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
              "-DSKEIN_BUILD_BENCH=ON"], ROOT)
        call(["cmake", "--build", args.build], ROOT)
    args.build = str(Path(args.build).resolve())
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(args.keep or scratch).resolve()
        work.mkdir(parents=True, exist_ok=True)
        bench = Bench(args, work)
        bench.kernel()
        bench.hxt()
        bench.tetgen()
        start, fine = bench.uniform()
        bench.layer(start)
        bench.coarsening(fine)
        bench.table()


if __name__ == "__main__":
    main()
