"""What cmake --install gives can be used: examples/embed is built with it by CMake and by pkg-config, and runs."""
import os
import re
import shutil
import subprocess
import unittest

BUILD, SOURCE, CMAKE = os.environ["SKEIN_BUILD"], os.environ["SKEIN_SOURCE"], os.environ["CMAKE"]
MPIRUN = [a for a in os.environ["SKEIN_MPIRUN"].replace(";", " ").split(" ") if a]
FOLDER = os.path.join(BUILD, "tests", "install")
PREFIX = os.path.join(FOLDER, "prefix")
EMBED = os.path.join(SOURCE, "examples", "embed")
HEADERS = {"skein.hpp", "skein.h", "error.hpp", "export.h", "version.h"}


def run(*args, **kwargs):
    done = subprocess.run([str(a) for a in args], capture_output=True, text=True, timeout=120, check=False, **kwargs)
    if done.returncode != 0:
        raise AssertionError(f"{args}:\n{done.stdout}\n{done.stderr}")
    return done.stdout


def pkg_config(*args):
    path = os.path.dirname(find("skein.pc"))
    env = {**os.environ, "PKG_CONFIG_PATH": path}
    return run("pkg-config", *args, "skein", env=env).split()


def find(name):
    found = [os.path.join(root, name) for root, _, files in os.walk(PREFIX) if name in files]
    if len(found) != 1:
        raise AssertionError(f"{name} is installed {len(found)} times")
    return found[0]


class Install(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(FOLDER, ignore_errors=True)
        run(CMAKE, "--install", BUILD, "--prefix", PREFIX)

    def test_only_what_is_public(self):
        self.assertEqual(set(os.listdir(os.path.join(PREFIX, "include"))), {"skein"})
        self.assertEqual(set(os.listdir(os.path.join(PREFIX, "include", "skein"))), HEADERS)
        self.assertIn("skein", run(find("skein"), "--version"))
        for name in ("SkeinTargets.cmake", "SkeinConfig.cmake", "skein.pc"):
            with open(find(name), encoding="utf-8") as f:
                text = f.read()
            for word in ("-Werror", "-Wall", "-march", "-O3", "-fno-", SOURCE + "/src", BUILD + "/include", "SKEIN_ASSERT",
                         "TETGEN", "tetgen", "libtet", "CGAL"):
                self.assertNotIn(word, text, name)

    def check_runs(self, program):
        for ranks in (1, 2, 3):
            lines = run(*MPIRUN, "-n", ranks, program).splitlines()
            self.assertEqual(len(lines), 5, lines)
            for line in lines:
                lost = float(re.search(r"lost by the transfer ([-+0-9.]+) %", line).group(1))
                self.assertLess(abs(lost), 2, line)

    def test_embed_with_cmake(self):
        build = os.path.join(FOLDER, "embed")
        run(CMAKE, "-S", EMBED, "-B", build, f"-DCMAKE_PREFIX_PATH={PREFIX}", "-DCMAKE_BUILD_TYPE=Release",
            "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Werror", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON")
        with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as f:
            self.assertNotIn("-march", f.read())
        run(CMAKE, "--build", build, "--parallel", 2)
        self.check_runs(os.path.join(build, "embed"))

    def test_embed_with_pkg_config(self):
        program = os.path.join(FOLDER, "embed-pkg-config")
        sources = [os.path.join(EMBED, name) for name in sorted(os.listdir(EMBED)) if name.endswith(".cpp")]
        run(os.environ["CXX"], "-std=c++17", "-O1", *sources, *pkg_config("--cflags", "--libs", "--static"), "-o", program)
        self.assertEqual(len(run(*MPIRUN, "-n", 2, program).splitlines()), 5)
        version = run(find("skein"), "--version").split()[-1]
        self.assertEqual(pkg_config("--modversion"), [version])

    def test_a_c_program_with_pkg_config(self):
        program = os.path.join(FOLDER, "c-program")
        run(os.environ["CC"], "-std=c11", os.path.join(SOURCE, "tests", "api", "c_api_test.c"),
            *pkg_config("--cflags", "--libs", "--static"), "-lm", "-o", program)


if __name__ == "__main__":
    unittest.main()
