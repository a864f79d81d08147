"""Every user error: the right exit code, one clear line, soon, and nothing left behind; on one rank and on two."""
import os
import subprocess
import unittest

import runner
from runner import Case, RANKS, isotropic, run, surface_only, write_mesh, write_solution

INVALID_MESH, USAGE, INPUT, OUTPUT = 1, 2, 3, 4
PRECIOUS = b"an old result that must survive\n"


class Errors(Case):
    def refused(self, code, words, *args, ranks_tried=RANKS):
        """The run fails as it must on 1 and 2 ranks; `words` are in its one line."""
        for ranks in ranks_tried:
            with self.subTest(ranks=ranks, args=args):
                before = self.contents()
                result = run(ranks, *args)
                self.judge(result, ranks, code, words)
                self.assertEqual(self.contents(), before, "files were left behind or changed")

    def judge(self, result, ranks, code, words):
        self.assertEqual(result.code, code, result.err)
        self.assertEqual(len(result.errors), 1, result.err)
        line = result.errors[0]
        self.assertTrue(line.startswith("skein: error: "), line)
        for word in words:
            self.assertIn(word, line)
        if ranks == 1:
            self.assertEqual(result.err, line + "\n")
        self.assertLess(result.seconds, runner.LIMIT)

    def contents(self):
        found = {}
        for folder, _, names in os.walk(self.folder):
            for name in names:
                with open(os.path.join(folder, name), "rb") as f:
                    found[os.path.join(folder, name)] = f.read()
        return found

    def adapt(self, mesh=None, metric=None, out=None):
        out = out or self.path("out.meshb")
        return ["adapt", mesh or self.good, "--metric", metric or self.metric, "-o", out, "--report",
                self.path("report.json"), "--metric-out", self.path("out.solb")]

    def keep_old_output(self):
        for name in ("out.meshb", "out.solb", "report.json"):
            with open(self.path(name), "wb") as f:
                f.write(PRECIOUS)

    # command line

    def test_usage(self):
        self.refused(USAGE, ["command is required"], ranks_tried=(1,))
        self.refused(USAGE, ["adpt", "not a command", "'adapt'"], "adpt", ranks_tried=(1,))
        self.refused(USAGE, ["IN"], "adapt", ranks_tried=(1,))
        self.refused(USAGE, ["--metric", "--size"], "adapt", self.good, "-o", self.path("out.meshb"), ranks_tried=(1,))
        self.refused(USAGE, ["--complexity"], "adapt", self.good, "--field", self.metric, "-o", self.path("out.meshb"), ranks_tried=(1,))
        self.refused(USAGE, ["--wrong"], *self.adapt(), "--wrong")
        self.refused(USAGE, ["--rounds"], *self.adapt(), "--rounds", "many", ranks_tried=(1,))
        self.refused(USAGE, ["--gradation"], *self.adapt(), "--gradation", "0.9", ranks_tried=(1,))
        self.refused(USAGE, ["--field-out", "--field-in"], *self.adapt(), "--field-out", self.path("f.sol"), ranks_tried=(1,))
        self.refused(USAGE, ["--field-in", "--field-out"], *self.adapt(), "--field-in", self.metric, ranks_tried=(1,))

    def test_words_that_nobody_knows(self):
        """A long option with one dash is no -h, and what may be meant is told."""
        for command, words in (("adapt", (("-hmax", "--hmax"), ("-hgrad", "--gradation"), ("-hsiz", "--size"),
                                          ("-out", "--output"), ("--complx", "--complexity"), ("--metrics", "--metric"),
                                          ("--rond=3", "--rounds"), ("-hmax=3", "--hmax"), ("-nosurf", "--no-surface"))),
                               ("generate", (("-sizemax", "--size-max"), ("--source", "--sources"))),
                               ("check", (("-json", "--json"),)), ("stats", (("--metrc", "--metric"),)),
                               ("convert", (("--mrge", "--merge"),)), ("partition", (("-parts", "--parts"),))):
            for word, meant in words:
                self.refused(USAGE, [word, f"did you mean {meant}?"], command, self.good, word, "3", ranks_tried=(1,))
        self.refused(USAGE, ["'generte'", "did you mean 'generate'?"], "generte", ranks_tried=(1,))
        self.refused(USAGE, ["-hmax", "the command comes before"], "-hmax", "3", "adapt", ranks_tried=(1,))

    def test_numbers(self):
        for words in (("--hmax", "-3"), ("--hmin", "nan"), ("--complexity", "1e400"), ("--max-elements", "0")):
            self.refused(USAGE, [words[0], "greater than 0"], *self.adapt(), *words, ranks_tried=(1,))

    def test_outputs_are_files_of_their_own(self):
        out = self.path("out.vtu")
        self.refused(USAGE, ["out.vtu", "two outputs"], "adapt", self.good, "--metric", self.metric, "-o", out, "--report",
                     os.path.join(self.folder, ".", "out.vtu"))
        self.refused(USAGE, ["good.mesh", "is an input", "--overwrite-input"], *self.adapt(out=self.good))
        self.refused(USAGE, ["good.sol", "is an input"], "adapt", self.good, "--metric", self.metric, "-o", out,
                     "--metric-out", self.metric, ranks_tried=(1,))
        os.symlink(self.good, self.path("link.mesh"))
        self.refused(USAGE, ["is an input"], "convert", self.good, self.path("link.mesh"), ranks_tried=(1,))
        self.refused(USAGE, ["is an input"], "partition", self.good, "--parts", "2", "-o", self.good, ranks_tried=(1,))
        self.assertEqual(run(1, "convert", self.good, self.good, "--overwrite-input").code, 0)

    def test_interrupted(self):
        write_solution(self.metric, [isotropic(0.01)] * len(self.verts))
        before = self.contents()
        for signal, code in (("INT", 130), ("TERM", 143)):
            result = run(1, *self.adapt(), prefix=("timeout", "--foreground", "--preserve-status", "-s", signal, "1"))
            self.judge(result, 0, code, ["interrupted"])
            self.assertEqual(self.contents(), before)

    # inputs

    def test_missing_file(self):
        missing = self.path("missing.meshb")
        self.refused(INPUT, ["missing.meshb", "no such file"], *self.adapt(mesh=missing))
        self.refused(INPUT, ["missing.sol", "no such file"], *self.adapt(metric=self.path("missing.sol")))
        for verb in (["check", missing], ["stats", missing], ["convert", missing, self.path("out.mesh")],
                     ["partition", missing, "--parts", "2"], ["generate", missing, "-o", self.path("out.mesh")]):
            result = run(1, *verb)
            self.judge(result, 1, INPUT, ["missing.meshb"])

    def test_fields_to_carry(self):
        short = self.path("short.sol")
        write_solution(short, [(1.0,)] * 7)
        out = ("--field-out", self.path("f.sol"))
        self.refused(INPUT, ["short.sol", "7 values", "64 vertices"], *self.adapt(), "--field-in", short, *out)
        self.refused(INPUT, ["missing.sol", "no such file"], *self.adapt(), "--field-in", self.path("missing.sol"), *out)
        self.refused(OUTPUT, ["f.txt"], *self.adapt(), "--field-in", self.metric, "--field-out", self.path("f.txt"))

    def test_unknown_format(self):
        other = self.path("mesh.stl")
        with open(other, "wb") as f:
            f.write(b"solid\n")
        self.refused(INPUT, ["mesh.stl", ".meshb"], *self.adapt(mesh=other))
        self.refused(OUTPUT, ["out.stl", ".meshb"], *self.adapt(out=self.path("out.stl")))

    def test_truncated_binary(self):
        whole, cut = self.path("whole.meshb"), self.path("cut.meshb")
        self.assertEqual(run(1, "convert", self.good, whole).code, 0)
        with open(whole, "rb") as f:
            data = f.read()
        with open(cut, "wb") as f:
            f.write(data[: len(data) * 2 // 3])
        self.keep_old_output()
        self.refused(INPUT, ["cut.meshb"], *self.adapt(mesh=cut))
        self.refused(INPUT, ["cut.meshb"], "check", cut)

    def test_nan_coordinates(self):
        self.verts[21] = (float("nan"), 0.5, 0.5)
        bad = self.path("nan.mesh")
        write_mesh(bad, self.verts, self.tets, self.tris)
        self.refused(INPUT, ["nan.mesh", "vertex 22"], *self.adapt(mesh=bad))

    def test_flat_tetrahedra(self):
        a, b, c, _ = self.tets[5]
        self.verts.append(tuple((self.verts[a][k] + self.verts[b][k]) / 2 for k in range(3)))
        self.tets[5] = (a, b, c, len(self.verts) - 1)
        self.tets[78] = (a, b, c, len(self.verts) - 1)
        write_solution(self.metric, [isotropic(0.25)] * len(self.verts))
        bad = self.path("inverted.mesh")
        write_mesh(bad, self.verts, self.tets, self.tris)
        self.keep_old_output()
        self.refused(INVALID_MESH, ["inverted.mesh", "flat", "6", "79"], *self.adapt(mesh=bad))

    def test_vertex_out_of_range(self):
        self.tets[10] = (*self.tets[10][:3], len(self.verts))
        bad = self.path("range.mesh")
        write_mesh(bad, self.verts, self.tets, self.tris)
        self.refused(INPUT, ["range.mesh", str(len(self.verts) + 1)], *self.adapt(mesh=bad))

    def test_metric_of_wrong_length(self):
        bad = self.path("short.sol")
        write_solution(bad, [isotropic(0.25)] * (len(self.verts) - 3))
        self.refused(INPUT, ["short.sol", str(len(self.verts) - 3), str(len(self.verts))], *self.adapt(metric=bad))

    def test_metric_not_positive_definite(self):
        rows = [isotropic(0.25)] * len(self.verts)
        rows[40] = (4, 0, -2, 0, 0, 1)
        bad = self.path("indefinite.sol")
        write_solution(bad, rows)
        self.keep_old_output()
        self.refused(INPUT, ["indefinite.sol", "vertex 41", "-2", "4"], *self.adapt(metric=bad))

    def test_metric_of_other_kind(self):
        sizes = self.path("sizes.sol")
        write_solution(sizes, [(0.25,)] * len(self.verts))
        self.refused(INPUT, ["sizes.sol", "--size"], *self.adapt(metric=sizes))
        write_solution(sizes, [(0.25,)] * 20 + [(0.0,)] + [(0.25,)] * (len(self.verts) - 21))
        self.refused(INPUT, ["sizes.sol", "vertex 21"], "adapt", self.good, "--size", sizes, "-o",
                     self.path("out.meshb"))

    def test_sizes_that_cannot_be_meant(self):
        sizes, out = self.path("sizes.sol"), self.path("out.meshb")
        n = len(self.verts)
        for h in (1e-30, 1e-4):
            write_solution(sizes, [(h,)] * n)
            self.refused(INPUT, ["sizes.sol", "tetrahedra are asked for", "GB", "--max-elements"], "adapt", self.good,
                         "--size", sizes, "-o", out)
        write_solution(sizes, [(0.05,)] * n)
        self.refused(INPUT, ["limit of 100", "--max-elements"], "adapt", self.good, "--size", sizes, "-o", out,
                     "--max-elements", "100")
        write_solution(sizes, [(0.25,)] * 20 + [(1e-150,)] + [(0.25,)] * (n - 21))
        self.refused(INPUT, ["sizes.sol", "vertex 21", "1e-150"], "adapt", self.good, "--size", sizes, "-o", out)

    def test_sizes_without_limit(self):
        out = self.path("out.mesh")
        for rows in ([isotropic(1e30)] * 64, [(0.0,) * 6] * 64, [(16.0, 0, 16.0, 0, 0, 0)] * 64):
            write_solution(self.metric, rows)
            for ranks in RANKS:
                result = run(ranks, "adapt", self.good, "--metric", self.metric, "-o", out)
                self.assertEqual(result.code, 0, result.err)
                self.assertEqual(run(1, "check", out).code, 0)

    def test_triangles_that_are_not_faces(self):
        self.tris[7] = (0, 1, len(self.verts) - 1, 1)
        bad = self.path("loose.mesh")
        write_mesh(bad, self.verts, self.tets, self.tris)
        self.refused(INVALID_MESH, ["loose.mesh", "triangle", "8"], *self.adapt(mesh=bad))

    # surfaces

    def surface(self, name, change):
        verts, tris = surface_only(self.verts, self.tris)
        path = self.path(name)
        write_mesh(path, verts, [], change(verts, tris))
        return path

    def test_open_surface(self):
        bad = self.surface("open.mesh", lambda verts, tris: tris[:-1])
        self.refused(INVALID_MESH, ["open.mesh"], "generate", bad, "-o", self.path("out.meshb"))

    def test_nonmanifold_surface(self):
        def fin(verts, tris):
            a, b, _, ref = tris[0]
            verts.append((2.0, 2.0, 2.0))
            return [*tris, (a, b, len(verts) - 1, ref)]

        bad = self.surface("fin.mesh", fin)
        self.keep_old_output()
        self.refused(INVALID_MESH, ["fin.mesh"], "generate", bad, "-o", self.path("out.meshb"))

    # outputs

    def test_missing_output_folder(self):
        self.refused(OUTPUT, ["nowhere"], *self.adapt(out=self.path("nowhere/out.meshb")))

    def test_output_is_a_folder(self):
        os.mkdir(self.path("out.meshb"))
        self.refused(OUTPUT, ["out.meshb"], *self.adapt())

    def test_read_only_output_folder(self):
        # root may write anywhere but there, where the kernel makes all files
        folder = "/proc"
        if os.geteuid() != 0:
            folder = self.path("locked")
            os.mkdir(folder)
            os.chmod(folder, 0o555)
        self.refused(OUTPUT, [folder], *self.adapt(out=os.path.join(folder, "out.meshb")))
        self.refused(OUTPUT, [folder], "adapt", self.good, "--metric", self.metric, "-o", self.path("out.meshb"),
                     "--report", os.path.join(folder, "report.json"))

    def test_no_space(self):
        small = self.path("small")
        os.mkdir(small)
        # a file system of 8 kB, in a mount namespace of the test's own; an old output fills most of it
        inside = (f"mount -t tmpfs -o size=8k skein {small} && printf precious > {small}/out.meshb && \"$@\"; "
                  f"code=$?; test \"$(ls -A {small})\" = out.meshb || echo LEFT: $(ls -A {small}); "
                  f"test \"$(cat {small}/out.meshb)\" = precious || echo HARMED; exit $code")
        enter = ["unshare", "-rm", "sh", "-c", inside, "sh"]
        if subprocess.run([*enter, "true"], capture_output=True, check=False).returncode != 0:
            self.skipTest("this system does not permit a file system of the test's own (unshare -rm, mount -t tmpfs)")
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                result = run(ranks, "adapt", self.good, "--metric", self.metric, "-o", os.path.join(small, "out.meshb"),
                             prefix=enter)
                self.judge(result, ranks, OUTPUT, ["out.meshb"])
                self.assertNotIn("LEFT", result.out)
                self.assertNotIn("HARMED", result.out)


if __name__ == "__main__":
    unittest.main()
