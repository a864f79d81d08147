#!/usr/bin/env python3
"""Strong and weak scaling of `skein adapt`, and what follows for other numbers of ranks. Standard library only.

    bench/scaling/run.py                           measure, print, plot; results in build/scaling
    bench/scaling/run.py --from build/scaling/runs.jsonl    print and plot again, e.g. with another network

Cores may be fewer than ranks and shared: CPU seconds, messages and bytes of each rank are judged, not wall time.
The case is a cube that the script makes with skein itself; with SKEIN_DATA set, ugawg-cube/polar2-start.meshb in it.
docs/scaling.md explains the columns and the model.
"""
import argparse
import json
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import case as cases
import model as models

ROOT = Path(__file__).resolve().parent.parent.parent


def numbers(text):
    return [int(float(w)) for w in text.split(",") if w]


def parse_arguments():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--skein", type=Path, default=ROOT / "build/release/bin/skein")
    p.add_argument("--out", type=Path, default=ROOT / "build/scaling", help="folder of the results")
    p.add_argument("--ranks", type=numbers, default=[1, 2, 4, 8, 16, 32])
    p.add_argument("--threads", type=int, default=1)
    p.add_argument("--strong", type=float, default=100000, help="complexity at every number of ranks; 0: none")
    p.add_argument("--weak", type=float, default=10000, help="complexity per rank; 0: none")
    p.add_argument("--latency", type=float, default=2e-6, help="of the modelled network, seconds per message")
    p.add_argument("--bandwidth", type=float, default=1e9, help="of the modelled network, bytes per second and rank")
    p.add_argument("--extrapolate", type=numbers, default=[100, 1000, 10000], help="ranks to predict for")
    p.add_argument("--elements", type=numbers, default=[10**9], help="tetrahedra of the predicted strong scaling")
    p.add_argument("--per-rank", type=numbers, default=[10**5, 10**6], help="... of the weak scaling, per rank")
    p.add_argument("--from", dest="source", type=Path, help="runs measured before (JSON lines)")
    return p.parse_args()


def measure_all(o):
    if not o.skein.exists():
        sys.exit(f"{o.skein} is missing; build it: cmake --preset release && cmake --build --preset release")
    if shutil.which("mpirun") is None:
        sys.exit("mpirun is missing (Debian: openmpi-bin)")
    o.out.mkdir(parents=True, exist_ok=True)
    plan = [("strong", p, o.strong) for p in o.ranks if o.strong > 0]
    plan += [("weak", p, o.weak * p) for p in o.ranks if o.weak > 0]
    runs = []
    with open(o.out / "log.txt", "w") as log, open(o.out / "runs.jsonl", "w") as lines:
        case = cases.make_case(o.skein, o.out, log)
        for kind, ranks, complexity in plan:
            print(f"{kind}, {ranks} ranks, complexity {complexity:g} ...", flush=True)
            run = cases.measure(o.skein, case, kind, ranks, complexity, o.threads, o.out, log)
            lines.write(json.dumps(run) + "\n")
            lines.flush()
            runs.append(run)
    return runs


def table(head, rows):
    """Markdown, columns aligned."""
    cells = [head] + [[str(c) for c in r] for r in rows]
    width = [max(len(r[i]) for r in cells) for i in range(len(head))]
    lines = ["| " + " | ".join(c.rjust(w) for c, w in zip(r, width)) + " |" for r in cells]
    lines.insert(1, "|" + "|".join("-" * (w + 1) + ":" for w in width) + "|")
    return "\n".join(lines)


def total_cpu(run):
    """Of all ranks, without communication."""
    return sum(p["cpu"]["mean"] for p in run["phases"]) * run["ranks"]


def longest_cpu(run):
    return sum(g["cpu"] for g in models.grouped(run).values())


def predicted(run, o):
    return sum(models.seconds(g, run["ranks"], o.latency, o.bandwidth) for g in models.grouped(run).values())


def efficiency(run, first, o):
    """Of the predicted time, against the run with the fewest ranks; the work is counted in tetrahedra made."""
    rate = run["elements_out"] / run["ranks"] / predicted(run, o)
    return 100 * rate / (first["elements_out"] / first["ranks"] / predicted(first, o))


def print_runs(kind, runs, o):
    runs = [r for r in runs if r["kind"] == kind]
    if not runs:
        return
    print(f"\n{kind} scaling: {runs[0]['case']}, {runs[0]['threads']} thread(s) per rank\n")
    head = ["ranks", "tetrahedra", "CPU all", "CPU longest", "round 1", "later", "partition", "other", "largest part",
            "MB/rank sent", "messages/rank", "collectives", "peak MB/rank", "predicted s", "efficiency %", "unit %", "Qmin"]
    rows = []
    for r in runs:
        groups = models.grouped(r)
        total = {q: sum(g[q] for g in groups.values()) for q in models.QUANTITIES}
        largest = r["phases"][-1].get("elements_max", 0) * r["ranks"] / r["elements_out"]
        rows.append([r["ranks"], f"{r['elements_out']:,}", f"{total_cpu(r):.2f}", f"{longest_cpu(r):.2f}"] +
                    [f"{groups[g]['cpu']:.2f}" for g in models.GROUPS] +
                    [f"{largest:.2f}", f"{total['bytes'] / 1e6:.1f}", f"{total['messages']:.0f}",
                     f"{total['collectives']:.0f}", f"{max(r['peak_bytes']) / 1e6:.0f}", f"{predicted(r, o):.2f}",
                     f"{efficiency(r, runs[0], o):.0f}", f"{r['unit_share']:.2f}", f"{r['quality_min']:.3f}"])
    print(table(head, rows))


def print_prediction(model, o):
    head = ["tetrahedra", "ranks", "per rank", "first round", "later rounds", "partition", "other", "all s",
            "of it network", "of it ~ P", "MB/rank"]
    rows = []
    plan = [(n, p) for n in o.elements for p in o.extrapolate] + [(m * p, p) for m in o.per_rank for p in o.extrapolate]
    for n, p in plan:
        t = model.predict(n, p, o.latency, o.bandwidth)
        rows.append([f"{n:.1e}", p, f"{n // p:,}"] + [f"{t[g]:.2f}" for g in models.GROUPS] +
                    [f"{t['all']:.2f}", f"{t['network']:.2f}", f"{t['growing']:.2f}", f"{t['memory'] / 1e6:.0f}"])
    print(f"\npredicted from runs on 2 to {model.most_ranks} ranks; latency {o.latency:g} s, "
          f"bandwidth {o.bandwidth:g} bytes/s per rank\n")
    print(table(head, rows))
    print("\nfitted: CPU seconds per million tetrahedra of a part, per 10,000 (N/P)^(2/3), per 1,000 ranks; imbalance (in "
          "the factors); messages per neighbourhood and per rank\n")
    rows = []
    for g in models.GROUPS:
        cpu = [f"{f * s:.3f}" for f, s in zip(model.factors[g, "cpu"], (1e6, 1e4, 1e3))]
        messages = [f"{f:.1f}" for f in model.factors[g, "messages"]]
        rows.append([g] + cpu + [f"{model.imbalance[g, 'cpu']:.2f}"] + messages)
    print(table(["phases", "volume", "interface", "ranks", "imbalance", "messages", "messages ~ P"], rows))


def plot(runs, model, o):
    if shutil.which("gnuplot") is None:
        print("\nno plot: gnuplot is missing (Debian: gnuplot-nox)")
        return
    script = ["set terminal svg size 1000,480 font 'sans,12'", f"set output '{o.out / 'scaling.svg'}'",
              "set multiplot layout 1,2", "set logscale xy 2", "set grid", "set key below", "set xlabel 'ranks'",
              "set ylabel 'seconds'"]
    blocks = []
    for kind in ("strong", "weak"):
        mine = [r for r in runs if r["kind"] == kind]
        if not mine:
            continue
        name, p0, t0 = f"${kind}", mine[0]["ranks"], longest_cpu(mine[0])
        blocks.append(f"{name} << EOD")
        for r in mine:
            ideal = t0 * p0 / r["ranks"] if kind == "strong" else t0
            first = models.grouped(r)["first round"]["cpu"]
            fitted = "?" if model is None or r["ranks"] == 1 else \
                model.predict(r["elements_out"], r["ranks"], o.latency, o.bandwidth)["all"]
            blocks.append(f"{r['ranks']} {longest_cpu(r)} {first} {ideal} {predicted(r, o)} {fitted}")
        blocks.append("EOD")
        script += [f"set title '{kind} scaling'",
                   f"plot {name} using 1:2 with linespoints title 'CPU of the slowest rank', "
                   f"{name} using 1:3 with linespoints title 'of it round 1', "
                   f"{name} using 1:5 with points pt 6 title 'with network', "
                   f"{name} using 1:6 with lines dt 3 lc rgb '#555555' title 'model', "
                   f"{name} using 1:4 with lines dt 2 lc rgb '#999999' title 'ideal'"]
    path = o.out / "scaling.gnuplot"
    path.write_text("\n".join(["set datafile missing '?'"] + blocks + script) + "\n")
    cases.subprocess.run(["gnuplot", str(path)], check=True)
    print(f"\nplot: {o.out / 'scaling.svg'}")


def main():
    o = parse_arguments()
    if o.source:
        runs = [json.loads(line) for line in o.source.read_text().splitlines()]
        o.out.mkdir(parents=True, exist_ok=True)
    else:
        runs = measure_all(o)
    for kind in ("strong", "weak"):
        print_runs(kind, runs, o)
    model = None
    try:
        model = models.Model(runs)
        print_prediction(model, o)
    except ValueError as e:
        print(f"\nno prediction: {e}")
    plot(runs, model, o)


if __name__ == "__main__":
    main()
