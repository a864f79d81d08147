"""Files that Skein writes are read by other programs: FreeFem++, Gmsh and meshio, each where it is installed."""
import os
import shutil
import subprocess
import unittest

from runner import Case, run, write_solution

FREEFEM_LIBRARIES = "/usr/lib/freefem++"  # where Debian has the plug-ins, which its FreeFem++ does not look for
FREEFEM = """load "msh3"
load "medit"
mesh3 Th = readmesh3(ARGV[ARGV.n-2]);
real[int] u = readsol(ARGV[ARGV.n-1]);
cout << "READ " << Th.nv << " " << Th.nt << " " << Th.nbe << " " << int3d(Th)(1.) << " " << u.n << " " << u.sum << endl;
"""
MESHIO = """import sys, meshio
m = meshio.read(sys.argv[1])
c = {b.type: len(b.data) for b in m.cells}
print("READ", len(m.points), c["tetra"], c["triangle"], *sorted(m.point_data))
"""
SYSTEM_PYTHON = "/usr/bin/python3"


def words(args, **environment):
    """What the program prints behind READ."""
    done = subprocess.run(args, capture_output=True, text=True, timeout=60, check=False,
                          env={**os.environ, **environment})
    lines = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("READ")]
    return lines[0] if lines else [done.stdout + done.stderr]


class Readers(Case):
    def setUp(self):
        super().setUp()
        self.field = self.path("u.sol")
        write_solution(self.field, [(x + 2 * y,) for x, y, _ in self.verts])
        self.sizes = [str(len(self.verts)), str(len(self.tets)), str(len(self.tris))]

    def convert(self, path, name, *options):
        self.assertEqual(run(1, "convert", path, self.path(name), *options).code, 0)
        return self.path(name)

    def test_versions(self):
        for options, version in (((), 2), (("--format-version", "3"), 3), (("--format-version", "4"), 4)):
            for given, name in ((self.good, "v.meshb"), (self.field, "v.solb")):
                with open(self.convert(given, name, *options), "rb") as f:
                    self.assertEqual(f.read(8), bytes([1, 0, 0, 0, version, 0, 0, 0]))

    def test_freefem(self):
        if shutil.which("FreeFem++") is None or not os.path.exists(FREEFEM_LIBRARIES + "/msh3.so"):
            self.skipTest("FreeFem++ is not installed (Debian: freefem++ libfreefem++)")
        with open(self.path("read.edp"), "w", encoding="ascii") as f:
            f.write(FREEFEM)
        text = self.convert(self.convert(self.good, "a.meshb"), "a.mesh")
        for mesh, field in (("a.meshb", self.convert(self.field, "u.solb")), (text, self.field)):
            found = words(["FreeFem++", "-nw", "-v", "0", self.path("read.edp"), self.path(mesh), field],
                          FF_LOADPATH=FREEFEM_LIBRARIES)
            self.assertEqual(found, [*self.sizes, "1", self.sizes[0], "96"])

    def test_gmsh(self):
        if shutil.which("gmsh") is None:
            self.skipTest("gmsh is not installed (Debian: gmsh)")
        text = self.convert(self.convert(self.good, "a.meshb"), "a.mesh")
        done = subprocess.run(["gmsh", text, "-save", "-o", self.path("g.msh"), "-format", "msh2"], capture_output=True,
                              text=True, timeout=60, check=False)
        with open(self.path("g.msh"), encoding="ascii") as f:
            lines = f.read().split("\n")
        self.assertEqual(lines[lines.index("$Nodes") + 1], self.sizes[0], done.stdout)
        kinds = [line.split()[1] for line in lines[lines.index("$Elements") + 2:lines.index("$EndElements")]]
        self.assertEqual([str(kinds.count("4")), str(kinds.count("2"))], self.sizes[1:])

    def test_meshio(self):
        have = [SYSTEM_PYTHON, "-c", "import meshio"]
        if not os.path.exists(SYSTEM_PYTHON) or subprocess.run(have, capture_output=True, check=False).returncode != 0:
            self.skipTest("meshio is not installed (Debian: python3-meshio)")
        for name in ("a.meshb", "a.mesh", "a.vtu"):
            found = words([SYSTEM_PYTHON, "-c", MESHIO, self.convert(self.good, name)])
            self.assertEqual(found[:3], self.sizes, name)


if __name__ == "__main__":
    unittest.main()
