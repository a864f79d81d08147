"""Runs the program on one case and judges what comes out."""
import filecmp
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time

import checker
import generator
import medit
import shape
import spec as specs

TIME_LIMIT = 40  # seconds; a case takes one or two. More is a hang
MPI_SETTINGS = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
                "OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_mpi_yield_when_idle": "1"}
EXTRA = {"surface": ["--no-surface"], "chapter": ["--method-preset", "chapter"], "quick": ["--method-preset", "quick"],
         "graded": ["--gradation", "1.5"], "free": ["--gradation", "0"]}


class Program:
    """Where skein and mpirun are. SKEIN and SKEIN_MPIRUN say so, as for the other tests."""

    def __init__(self, skein, limit=TIME_LIMIT, ignored=()):
        self.skein, self.limit, self.ignored = skein, limit, tuple(ignored)
        words = os.environ.get("SKEIN_MPIRUN", "mpirun --oversubscribe --bind-to none").replace(";", " ")
        self.mpirun = words.split()
        self.environment = {**os.environ, **MPI_SETTINGS}

    def command(self, spec, names, sizes):
        """The command for files (mesh, solution, new mesh)."""
        mesh, solution, new = names
        args = [self.skein, "adapt", mesh, "--size" if sizes else "--metric", solution, "-o", new, "--threads",
                str(spec["threads"]), "--rounds", str(spec["rounds"]), "--quiet", *EXTRA.get(spec["extra"], [])]
        return args if spec["ranks"] == 1 else [*self.mpirun, "-n", str(spec["ranks"]), *args]


class Outcome:
    """What became of one case: `faults`, pairs of kind and sentence, the gravest first; none if all is well."""

    def __init__(self, spec):
        self.spec, self.faults, self.before, self.after = spec, [], {}, {}
        self.seconds, self.command, self.skipped = 0.0, [], False

    @property
    def kinds(self):
        return [kind for kind, _ in self.faults]

    def record(self):
        """For the JSON line of the run."""
        return {"case": specs.write(self.spec), "seed": self.spec["seed"], "ranks": self.spec["ranks"],
                "threads": self.spec["threads"], "seconds": round(self.seconds, 3), "before": self.before,
                "after": self.after, "faults": self.faults, "skipped": self.skipped}


def end_kind(code, text):
    """The kind of fault of a run that ended with an error: the code, and the message without numbers."""
    if code < 0:
        return f"signal.{signal.Signals(-code).name}"
    died = re.search(r"exited on (signal \d+)", text) or re.search(r"(Segmentation fault|terminate called)", text)
    told = re.search(r"skein: (?:internal )?error: (.*)", text)
    # what the message says, without paths and numbers
    words = re.sub(r"-?\d[\d.e+-]*", "#", re.sub(r"\S*/", "", told.group(1))) if told else died.group(1) if died else ""
    return f"exit.{code}: {words[:110]}".strip(": ")


def execute(command, folder, program):
    """Exit code (None: out of time), output. All processes that it started end with it."""
    with open(os.path.join(folder, "log.txt"), "w", encoding="utf-8") as log:
        process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=program.environment,
                                   stdin=subprocess.DEVNULL, start_new_session=True)
        try:
            code = process.wait(program.limit)
        except subprocess.TimeoutExpired:
            code = None
            os.killpg(process.pid, signal.SIGTERM)  # mpirun ends its ranks, which have process groups of their own
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
    with open(os.path.join(folder, "log.txt"), encoding="utf-8", errors="replace") as log:
        return code, log.read()


def adapt(outcome, mesh, solution, folder, number, program):
    """Writes the files of one pass, runs it. Returns the new mesh, or None when there are faults."""
    names = [os.path.join(folder, name + number) for name in ("in", "in", "out")]
    names = [name + end for name, end in zip(names, (".mesh", ".sol", ".mesh"))]
    medit.write_mesh(names[0], mesh)
    medit.write_solution(names[1], solution)
    outcome.command = program.command(outcome.spec, names, solution.ndim == 1)
    begin = time.monotonic()
    code, text = execute(outcome.command, folder, program)
    outcome.seconds += time.monotonic() - begin
    if code != 0:
        kind = "hang" if code is None else end_kind(code, text)
        outcome.faults = [(kind, f"after {outcome.seconds:.1f} s: {text.strip()[:600]}")]
        return None
    try:
        return medit.read_mesh(names[2])
    except (OSError, medit.BadFile) as error:
        outcome.faults = [("bad-file", str(error))]
    return None


def repeat(outcome, mesh, solution, folder, program):
    """The same run once more: the same bytes must come out."""
    before = outcome.faults
    again = adapt(outcome, mesh, solution, folder, "1", program)
    if again is None:
        outcome.faults = before + outcome.faults
        return
    if not filecmp.cmp(os.path.join(folder, "out.mesh"), os.path.join(folder, "out1.mesh"), shallow=False):
        outcome.faults = before + [("not-repeatable", f"the same run gives another mesh: {outcome.after} and {again.counts()}")]


def passes(outcome, mesh, solution, folder, program):
    """Adapts, and checks the result; once more, to coarse sizes, if the case says so."""
    spec = outcome.spec
    tolerance = checker.BENT if spec["bend"] else checker.FLAT
    after = adapt(outcome, mesh, solution, folder, "", program)
    if after is not None:
        outcome.after = after.counts()
        outcome.faults = checker.check(mesh, after, tolerance)
    if spec["same"] and after is not None:
        repeat(outcome, mesh, solution, folder, program)
    if spec["again"] and not outcome.faults:
        after = adapt(outcome, after, shape.coarse(spec, len(after.coords)), folder, "2", program)
        if after is not None:
            outcome.faults = checker.check(mesh, after, tolerance)


def run(spec, program, keep=None):
    """Makes the case, runs the program on it, checks the result. `keep` is a folder for its files."""
    outcome = Outcome(spec)
    mesh, solution = generator.build(spec)
    if solution is None:
        outcome.skipped = True
        return outcome
    outcome.before = mesh.counts()
    folder = tempfile.mkdtemp(prefix="skein-campaign-") if keep is None else keep
    os.makedirs(folder, exist_ok=True)
    try:
        passes(outcome, mesh, solution, folder, program)
        outcome.faults = [f for f in outcome.faults if not f[0].startswith(program.ignored)]
    finally:
        if keep is None:
            shutil.rmtree(folder, ignore_errors=True)
    return outcome
