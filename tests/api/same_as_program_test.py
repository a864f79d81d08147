"""In memory the library gives what the program gives with files, byte by byte."""
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "app"))
from runner import MPIRUN, SKEIN, Case, write_solution  # noqa: E402

IN_MEMORY = os.environ["IN_MEMORY"]


def size(x, y, z):
    return 0.08 + 0.1 * x * x + 0.03 * y


class SameAsProgram(Case):
    def run_both(self, ranks, kind, sol):
        out = {}
        for name in ("program", "memory"):
            mesh, fields = self.path(f"{name}.meshb"), self.path(f"{name}.sol")
            args = {"program": [SKEIN, "adapt", self.good, kind, sol, "-o", mesh, "--field-in", sol, "--field-out",
                                fields, "--quiet"],
                    "memory": [IN_MEMORY, self.good, kind, sol, mesh, fields]}[name]
            done = subprocess.run([*MPIRUN, "-n", str(ranks), *args], capture_output=True, text=True, timeout=60,
                                  check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            out[name] = tuple(open(path, "rb").read() for path in (mesh, fields))
        return out

    def test_same_bytes(self):
        sizes, metric = self.path("size.sol"), self.path("metric.sol")
        write_solution(sizes, [(size(*v),) for v in self.verts])
        write_solution(metric, [(30 + 20 * x, 5 * y, 90, 0, 10 * z, 150) for x, y, z in self.verts])
        for ranks in (1, 2, 3):
            for kind, sol in (("--size", sizes), ("--metric", metric)):
                with self.subTest(ranks=ranks, kind=kind):
                    out = self.run_both(ranks, kind, sol)
                    self.assertGreater(len(out["program"][0]), 20000)
                    self.assertEqual(out["program"], out["memory"])


if __name__ == "__main__":
    unittest.main()
