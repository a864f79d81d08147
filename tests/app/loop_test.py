"""The loops of the examples: the mesh keeps its number of elements and fits the solution better and better."""
import os
import re
import shutil
import subprocess
import unittest

import runner
from runner import Case, run

EXAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "examples")
FREEFEM_LIBRARIES = "/usr/lib/freefem++"


class Loop(Case):
    def loop(self, name):
        """Tetrahedra and error of the four meshes."""
        done = subprocess.run(["bash", os.path.join(EXAMPLES, name, "loop.sh"), self.path("loop")], capture_output=True,
                              text=True, timeout=200, check=False,
                              env={**os.environ, "SKEIN": runner.SKEIN, "SKEIN_MPIRUN": " ".join(runner.MPIRUN)})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = [(int(n), float(e)) for n, e in re.findall(r"(\d+) tetrahedra, error ([-\d.e]+)", done.stdout)]
        self.assertEqual(len(rows), 4, done.stdout)
        for tets, _ in rows[1:]:
            self.assertLess(abs(tets / 20000 - 1), 0.05)
        return rows

    def test_freefem(self):
        if shutil.which("FreeFem++") is None or not os.path.exists(FREEFEM_LIBRARIES + "/msh3.so"):
            self.skipTest("FreeFem++ is not installed (Debian: freefem++ libfreefem++)")
        rows = self.loop("freefem")
        self.assertLess(rows[3][1], rows[0][1] / 100)

    def test_tutorial(self):
        rows = self.loop("loop")
        self.assertLess(rows[3][1], rows[0][1] / 15)
        self.assertLess(rows[2][1], rows[1][1])
        self.assertEqual(run(1, "check", self.path("loop/mesh3.mesh")).code, 0)
        self.assertGreater(os.path.getsize(self.path("loop/picture.vtu")), 100000)


if __name__ == "__main__":
    unittest.main()
