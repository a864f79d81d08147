#!/usr/bin/env python3
"""Plants violations in a copy of a tiny tree and sees that check_rules.py catches each, and passes the clean tree."""
import subprocess
import sys
import tempfile
from pathlib import Path

CHECKER = Path(sys.argv[1]).resolve()

CLEAN = {
    "comm/comm.cpp": '#include <mpi.h>\n#include "base/ids.hpp"\nint f() { return MPI_Finalize(); }\n',
    "src/base/ids.hpp": "#pragma once\n// MPI_Init is only spoken of here.\n",
    "src/metric/tensor.hpp": '#pragma once\n#include "base/ids.hpp"\nconst char* s = "MPI_Init";\n',
    "src/app/main.cpp": '#include "adapt/adapt.hpp"\n#include "generate/generate.hpp"\n',
    "include/skein/skein.hpp": '#pragma once\n#include <mpi.h>\n#include "skein/error.hpp"\nint adapt(MPI_Comm comm);\n',
    "src/api/adapt.cpp": '#include "skein/skein.hpp"\nint adapt(MPI_Comm comm) { return from(&comm); }\n',
    "src/mesh/mesh_slice.hpp": '#pragma once\n#include "base/ids.hpp"\n',
    "src/dist/dist_mesh.hpp": '#pragma once\n#include "comm/comm.hpp"\n#include "mesh/mesh_slice.hpp"\n',
}
# name of the case: (file, text, what the checker must say)
PLANTED = {
    "mpi.h outside comm": ("src/kernel/cavity.cpp", "#include <mpi.h>\n", "<mpi.h> is included outside comm/"),
    "MPI call outside comm": ("partition/part.cpp", "void f() { MPI_Barrier(c); }\n", "MPI_Barrier is used"),
    "MPI in an example": ("examples/a/field.cpp", "#include <mpi.h>\n", "<mpi.h> is included outside comm/"),
    "mesh includes metric": ("src/mesh/a.cpp", '#include "metric/measure.hpp"\n', "mesh must not include metric"),
    "kernel includes comm": ("src/kernel/a.hpp", '#pragma once\n#include "comm/comm.hpp"\n', "kernel must not include comm"),
    "partition includes mesh": ("partition/a.cpp", '#include "mesh/tet_mesh.hpp"\n', "partition must not include mesh"),
    "dist includes adapt": ("src/dist/a.cpp", '#include "adapt/adapt.hpp"\n', "dist must not include adapt"),
    "base includes mesh": ("src/base/a.cpp", '#include "mesh/tet_mesh.hpp"\n', "base must not include mesh"),
    "mesh slice includes comm": ("src/mesh/mesh_slice.hpp", '#pragma once\n#include "comm/comm.hpp"\n', "mesh must not include comm"),
    "adapt includes generate": ("src/adapt/a.cpp", '#include "generate/generate.hpp"\n', "adapt must not include generate"),
    "include by src/": ("src/metric/a.cpp", '#include "src/io/mesh_io.hpp"\n', "metric must not include io"),
    "climbing include": ("src/metric/a.cpp", '#include "../base/ids.hpp"\n', "write the path from the root"),
    "long file": ("src/metric/a.cpp", "int a;\n" * 401, "401 lines without comments"),
    "no pragma once": ("src/metric/a.hpp", "int a;\n", "needs #pragma once"),
    "public header includes a room": ("include/skein/a.hpp", '#pragma once\n#include "base/ids.hpp"\n', "skein must not include base"),
    "MPI call in src/api": ("src/api/a.cpp", "void f(MPI_Comm c) { MPI_Barrier(c); }\n", "MPI_Barrier is used"),
    "foreign path": ("docs/a.md", "see /ho" + "me/me/notes\n", "names a path of one machine"),
}


def run(root):
    done = subprocess.run([sys.executable, CHECKER, root], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


def plant(root, files):
    for name, text in files.items():
        path = Path(root, name)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def main():
    failures = []
    with tempfile.TemporaryDirectory() as root:
        plant(root, CLEAN)
        code, out = run(root)
        if code != 0:
            failures.append(f"the clean tree is refused:\n{out}")
    for case, (name, text, expected) in PLANTED.items():
        with tempfile.TemporaryDirectory() as root:
            plant(root, CLEAN | {name: text})
            code, out = run(root)
            if code != 1 or f"{name}:" not in out or expected not in out:
                failures.append(f"'{case}' is not caught (exit code {code}):\n{out}")
    with tempfile.TemporaryDirectory() as root:
        if run(root)[0] == 0:
            failures.append("an empty tree passes")
    print("\n".join(failures) or f"all {len(PLANTED)} planted violations are caught")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
