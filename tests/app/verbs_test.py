"""Every verb does its work, on one rank and on two."""
import json
import os
import unittest

import runner
from runner import Case, RANKS, isotropic, read_rows, run, surface_only, write_mesh, write_solution


class Verbs(Case):
    def done(self, ranks, *args):
        result = run(ranks, *args)
        self.assertEqual(result.code, 0, result.out + result.err)
        self.assertEqual(result.errors, [])
        return result

    def json(self, ranks, *args):
        return json.loads(self.done(ranks, *args, "--json").out)

    def assert_valid_cube(self, mesh, regions=None):
        found = self.json(1, "check", mesh)
        self.assertTrue(found["valid"], found)
        self.assertAlmostEqual(found["volume"], 1, delta=1e-12)
        self.assertAlmostEqual(found["area"], 6, delta=1e-11)
        self.assertEqual(found["hull_euler"], 2)
        return found

    def test_help_and_version(self):
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                self.assertLessEqual(max(map(len, self.done(ranks, "--help").out.splitlines())), 80)
                self.assertEqual(self.done(ranks, "--version").out.count("skein "), 1)
                for verb in ("adapt", "generate", "check", "stats", "convert", "partition"):
                    if ranks == 1 or verb == "adapt":
                        text = self.done(ranks, verb, "--help").out
                        self.assertEqual(text.count("Example: "), 1)
                        self.assertLessEqual(max(map(len, text.splitlines())), 80)

    def test_adapt(self):
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                out, report, metric = self.path("a.meshb"), self.path("a.json"), self.path("a.solb")
                result = self.done(ranks, "adapt", self.good, "--metric", self.metric, "--complexity", "60", "-o", out,
                                   "--report", report, "--metric-out", metric, "--threads", "2")
                self.assertIn("balance", result.out)
                found = self.assert_valid_cube(out)
                with open(report, encoding="utf-8") as f:
                    told = json.load(f)
                self.assertEqual(told["elements_in"], len(self.tets))
                self.assertEqual(told["vertices_in"], len(self.verts))
                self.assertEqual((told["elements_out"], told["vertices_out"]), (found["tets"], found["vertices"]))
                self.assertEqual((told["ranks"], told["threads"]), (ranks, 2))
                self.assertEqual(len(told["peak_bytes"]), ranks)
                self.assertAlmostEqual(told["complexity"], 60, delta=1e-3)
                for name in ("total", "read", "distribute", "adapt", "write"):
                    self.assertIn(name, told["seconds"])
                self.assertIn("insert", {name for p in told["phases"] for name in p["operations"]})
                for words in ("skein 0", "input: 1 region", "expected: ", "rounds: ", "worst element: quality"):
                    self.assertEqual(result.out.count(words), 1, words)
                self.assertLess(abs(told["elements_expected"] / told["elements_out"] - 1), 0.2)
                self.assertEqual([p["ref"] for p in told["patches"]], [1, 2, 3, 4, 5, 6])
                for p in told["patches"]:
                    self.assertEqual(p["elements_in"], 18)
                    self.assertAlmostEqual(p["area_in"], 1, delta=1e-12)
                    self.assertAlmostEqual(p["area_out"], 1, delta=1e-12)
                self.assertEqual(told["regions"][0]["elements_out"], told["elements_out"])
                self.assertAlmostEqual(told["worst"]["quality"], told["quality"]["min"], delta=1e-9)
                for key in ("hmin", "hmax", "gradation", "norm", "max_elements", "merge", "optim"):
                    self.assertIn(key, told["options"])
                # the files written tell the same as the report
                stats = self.json(ranks, "stats", out, "--metric", metric)
                self.assertEqual(stats["edges"], told["edges"])
                for part in ("length", "quality"):
                    for name, value in told[part].items():
                        self.assertAlmostEqual(stats[part][name], value, places=9, msg=name)

    def test_threads_that_share_a_core_are_told(self):
        core = str(min(os.sched_getaffinity(0)))
        for prefix, notes in ((("taskset", "-c", core), 1), ((), 0 if len(os.sched_getaffinity(0)) > 1 else 1)):
            result = run(1, "adapt", self.good, "--metric", self.metric, "-o", self.path("s.meshb"), "--threads", "2",
                         prefix=prefix)
            self.assertEqual((result.code, result.out.count("share 1 core")), (0, notes))

    def test_adapt_to_sizes_quietly(self):
        sizes, out = self.path("h.sol"), self.path("b.vtu")
        write_solution(sizes, [(0.2 + 0.2 * x,) for x, _, _ in self.verts])
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                result = self.done(ranks, "adapt", self.good, "--size", sizes, "-o", out, "--quiet", "--no-surface",
                                   "--hmin", "0.25", "--hmax", "0.35")
                self.assertEqual(result.out, "")
                self.assertGreater(os.path.getsize(out), 1000)

    def test_adapt_to_a_field(self):
        field, out = self.path("u.sol"), self.path("c.mesh")
        write_solution(field, [(x * x + 0.1 * y * y + 0.1 * z * z,) for x, y, z in self.verts])
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                self.done(ranks, "adapt", self.good, "--field", field, "--complexity", "60", "-o", out)
                self.assert_valid_cube(out)

    def adapted(self, *options, ranks=1):
        """The report of an adaptation of good.mesh, and its mesh."""
        out, report = self.path("o.mesh"), self.path("o.json")
        self.done(ranks, "adapt", self.good, *options, "-o", out, "--report", report)
        with open(report, encoding="utf-8") as f:
            return json.load(f), out

    def test_what_sizes_can_be_made_of(self):
        told, _ = self.adapted("--size", "0.2", "--gradation", "0")
        self.assertAlmostEqual(told["complexity"], 125, delta=1e-6)
        self.assertEqual(told["options"]["size"], ["0.2"])
        told, _ = self.adapted("--optim", ranks=2)
        self.assertLess(abs(told["elements_out"] / len(self.tets) - 1), 0.3)
        # the strictest of two
        coarse = self.path("coarse.sol")
        write_solution(coarse, [isotropic(0.5)] * len(self.verts))
        told, _ = self.adapted("--metric", coarse, "--metric", self.metric)
        self.assertAlmostEqual(told["complexity"], 64, delta=1e-6)
        # one of several fields, by its number, and the only one of its kind
        many = self.path("many.sol")
        with open(many, "w", encoding="ascii") as f:
            f.write(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(self.verts)}\n3 1 1 3\n")
            f.writelines(f"0 {x * x!r} 16 0 16 0 0 16\n" for x, _, _ in self.verts)
        told, _ = self.adapted("--metric", many)
        self.assertAlmostEqual(told["complexity"], 64, delta=1e-6)
        told, _ = self.adapted("--field", many + ":2", "--elements", "2000")
        self.assertLess(abs(told["elements_out"] / 2000 - 1), 0.05)
        for words, wrong in ((["many.sol", "3 fields", "many.sol:1"], many), (["no field 9"], many + ":9")):
            result = run(1, "adapt", self.good, "--field", wrong, "--complexity", "60", "-o", self.path("o.mesh"))
            self.assertEqual(result.code, 3)
            for word in words:
                self.assertIn(word, result.err)

    def test_a_constant_field_is_told(self):
        flat = self.path("flat.sol")
        write_solution(flat, [(3.5,)] * len(self.verts))
        out = self.done(1, "adapt", self.good, "--field", flat, "--complexity", "60", "-o", self.path("o.mesh")).out
        self.assertIn("the field is 3.5 everywhere", out)

    def test_sources_local_sizes_and_frozen_patches(self):
        sources, local = self.path("s.toml"), self.path("l.toml")
        with open(sources, "w", encoding="ascii") as f:
            f.write("size_max = 0.5\n[[point]]\nat = [0, 0, 0]\nspacing = 0.05\nr1 = 0.1\nr2 = 0.2\n")
        told, out = self.adapted("--sources", sources)
        self.assert_valid_cube(out)
        near = sum(1 for x, y, z, _ in read_rows(out, "Vertices", 4) if max(x, y, z) < 0.2)
        far = sum(1 for x, y, z, _ in read_rows(out, "Vertices", 4) if min(x, y, z) > 0.5)
        self.assertGreater(near, 3 * far)
        with open(local, "w", encoding="ascii") as f:
            f.write("[names]\nfloor = 5\n[[patch]]\nname = \"floor\"\nsize = 0.1\n[[patch]]\nref = 6\nfreeze = true\n")
        _, out = self.adapted("--size", "0.3", "--local", local, "--freeze-ref", "patch:1,2", ranks=2)
        faces = [int(row[3]) for row in read_rows(out, "Triangles", 4)]
        self.assertEqual([faces.count(ref) for ref in (1, 2, 6)], [18, 18, 18])
        self.assertGreater(faces.count(5), 5 * 18)
        result = run(1, "adapt", self.good, "--size", "0.3", "--freeze-ref", "77", "-o", out)
        self.assertEqual((result.code, "no patch or region 77" in result.err), (3, True), result.err)

    def test_fields_travel(self):
        scalar, rest, sizes = self.path("p.sol"), self.path("rest.sol"), self.path("h.sol")
        write_solution(scalar, [(1 + x - 2 * y + 3 * z,) for x, y, z in self.verts])
        write_solution(rest, [(x, y, z, x + y, y + z, 1) for x, y, z in self.verts])
        write_solution(sizes, [(0.1 if x == 0 else 0.5,) for x, _, _ in self.verts])
        mesh, out = self.path("f.mesh"), self.path("f.sol")
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                result = self.done(ranks, "adapt", self.good, "--size", sizes, "-o", mesh, "--field-in", scalar,
                                   "--field-in", rest, "--field-out", out)
                self.assertIn("gradation: stricter at", result.out)
                self.assertIn("transfer fields", result.out)
                places, values = read_rows(mesh, "Vertices", 4), read_rows(out, "SolAtVertices", 7, skip=3)
                self.assertEqual(len(places), len(values))
                for (x, y, z, _), row in zip(places, values):
                    expected = (1 + x - 2 * y + 3 * z, x, y, z, x + y, y + z, 1)
                    for a, b in zip(row, expected):
                        self.assertAlmostEqual(a, b, delta=1e-13)
        vtu = self.path("f.vtu")
        self.done(1, "adapt", self.good, "--size", sizes, "--gradation", "0", "-o", vtu, "--field-in", scalar)
        with open(vtu, "rb") as f:
            self.assertIn(b'Name="p"', f.read(2000))

    def test_generate(self):
        surface, sources, out = self.path("s.mesh"), self.path("s.toml"), self.path("g.meshb")
        verts, tris = surface_only(self.verts, self.tris)
        write_mesh(surface, verts, [], tris)
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                report = self.path("g.json")
                self.done(ranks, "generate", surface, "-o", out, "--size-max", "0.3", "--report", report)
                found = self.assert_valid_cube(out)
                with open(report, encoding="utf-8") as f:
                    self.assertEqual(json.load(f)["elements_out"], found["tets"])

    def test_check(self):
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                self.assertIn("valid", self.done(ranks, "check", self.good).out)
        bad = self.path("bad.mesh")
        a, b, c, d = self.tets[5]
        tets = [*self.tets[:5], (b, a, c, d), *self.tets[6:], self.tets[30]]
        verts = [*self.verts, (5.0, 5.0, 5.0), self.verts[3]]
        write_mesh(bad, verts, tets, [*self.tris[1:], (0, 1, 40, 9), self.tris[9]])
        first = None
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                result = run(ranks, "check", bad, "--json")
                self.assertEqual((result.code, result.errors), (1, []))
                found = json.loads(result.out)
                self.assertFalse(found["valid"])
                self.assertEqual(found["nonpositive_tets"], 1)
                self.assertEqual(found["findings"]["nonpositive_tets"][0]["tetrahedron"], 6)
                self.assertEqual(found["misoriented_pairs"] + found["faces_over_2"] >= 4, True)
                self.assertEqual(found["duplicate_tets"], 1)
                self.assertEqual(found["findings"]["duplicate_tets"][0]["other"], 31)
                self.assertEqual(found["hull_faces_not_triangles"], 1)
                self.assertEqual(found["triangles_not_faces"], 1)
                self.assertEqual(found["findings"]["triangles_not_faces"][0]["vertices"], [1, 2, 41])
                self.assertEqual(found["duplicate_triangles"], 1)
                self.assertEqual(found["unused_vertices"], 2)
                self.assertEqual(found["findings"]["duplicate_vertices"][0]["other"], 4)
                for sums in ("volume", "area"):
                    del found[sums]
                first = first or found
                self.assertEqual(found, first)
                text = run(ranks, "check", bad)
                self.assertEqual(text.code, 1)
                self.assertIn("tetrahedron 6", text.out)

    def test_check_of_surfaces_and_of_meshes_without_triangles(self):
        surface, bare = self.path("s.mesh"), self.path("bare.mesh")
        verts, tris = surface_only(self.verts, self.tris)
        write_mesh(surface, verts, [], tris)
        write_mesh(bare, self.verts, self.tets, [])
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                found = self.json(ranks, "check", surface)
                self.assertTrue(found["valid"] and found["oriented"])
                self.assertAlmostEqual(found["volume"], 1, delta=1e-12)
                self.assertTrue(self.json(ranks, "check", bare)["valid"])
        self.assertIn("encloses a volume of 1", self.done(1, "check", surface).out)
        write_mesh(surface, verts, [], [tris[0][:2][::-1] + tris[0][2:], *tris[1:]])
        found = self.json(2, "check", surface)
        self.assertEqual((found["oriented"], found["volume"]), (False, 0))

    def test_sections_that_are_not_kept_are_told_once(self):
        odd = self.path("odd.mesh")
        with open(self.good, encoding="ascii") as f:
            text = f.read()
        with open(odd, "w", encoding="ascii") as f:
            f.write(text.replace("End", "Normals\n1\n0 0 1\nTangents\n1\n0 0 1\nEnd"))
        for ranks in RANKS:
            out = self.done(ranks, "convert", odd, self.path("even.mesh")).out
            self.assertEqual(out.count("Normals, Tangents"), 1)

    def test_check_lists_ten_of_a_kind(self):
        bad = self.path("bad.mesh")
        write_mesh(bad, self.verts, self.tets, self.tris[20:])
        result = run(1, "check", bad, "--json")
        found = json.loads(result.out)
        self.assertEqual(found["hull_faces_not_triangles"], 20)
        self.assertEqual(len(found["findings"]["hull_faces_not_triangles"]), 10)

    def test_stats(self):
        one = self.json(1, "stats", self.good, "--metric", self.metric, "--complexity", "100")
        two = self.json(2, "stats", self.good, "--metric", self.metric, "--complexity", "100")
        self.assertAlmostEqual(one["complexity"], 100, delta=1e-9)
        self.assertEqual(one["tets"], len(self.tets))
        self.assertEqual(one["vertices"] - one["edges"] + (4 * one["tets"] + len(self.tris)) // 2 - one["tets"], 1)
        self.assert_close(one, two)
        self.assertEqual(one["dihedral"]["histogram_10deg"], two["dihedral"]["histogram_10deg"])
        plain = self.done(2, "stats", self.good).out
        self.assertIn("dihedral", plain)
        self.assertNotIn("quality", plain)

    def mean_ratio(self, tet):
        """36/3^(1/3) V^(2/3) over the sum of the squares of the edges."""
        x = [self.verts[v] for v in tet]
        e = [[x[k][i] - x[0][i] for i in range(3)] for k in (1, 2, 3)]
        cross = [e[1][(i + 1) % 3] * e[2][(i + 2) % 3] - e[1][(i + 2) % 3] * e[2][(i + 1) % 3] for i in range(3)]
        volume = sum(c * d for c, d in zip(e[0], cross)) / 6
        squares = sum((p - q) ** 2 for i in range(4) for j in range(i) for p, q in zip(x[i], x[j]))
        return 36 / 3 ** (1 / 3) * volume ** (2 / 3) / squares

    def test_where_it_is_bad(self):
        bad = self.path("bad.mesh")
        inside = next(v for v, x in enumerate(self.verts) if all(0 < c < 1 for c in x))
        self.verts[inside] = (0.15, 0.3, 0.2)
        write_mesh(bad, self.verts, self.tets, self.tris)
        qualities = [self.mean_ratio(t) for t in self.tets]
        for ranks in RANKS:
            found = self.json(ranks, "stats", bad, "--worst", "3")["worst"]
            for w, q in zip(found, sorted(qualities)[:3]):
                self.assertAlmostEqual(w["quality"], q, delta=1e-12)
                self.assertAlmostEqual(qualities[w["tetrahedron"] - 1], q, delta=1e-12)
                corners = [self.verts[v] for v in self.tets[w["tetrahedron"] - 1]]
                for k in range(3):
                    self.assertAlmostEqual(w["at"][k], sum(x[k] for x in corners) / 4, delta=1e-12)
        self.assertIn(f"tetrahedron {found[0]['tetrahedron']}: quality", self.done(1, "stats", bad, "--worst", "1").out)

    def test_pictures_have_what_there_is_to_see(self):
        arrays = ("ref", "quality", "edge_length", "aspect_ratio", "min_dihedral", "part")
        with_field, adapted = self.path("w.vtu"), self.path("a.pvtu")
        field = self.path("mach.sol")
        write_solution(field, [(x,) for x, _, _ in self.verts])
        self.done(2, "convert", self.good, with_field, "--with", field, "--with", self.metric)
        self.done(2, "adapt", self.good, "--size", "0.3", "-o", adapted)
        for path, more in ((with_field, ("mach", "good")), (adapted, ("size", "metric"))):
            with open(path, "rb") as f:
                head = f.read(4000).decode("latin-1")
            for name in arrays + more:
                self.assertIn(f'Name="{name}"', head)
        result = run(1, "convert", self.good, self.path("x.mesh"), "--with", field)
        self.assertEqual((result.code, ".vtu" in result.err), (2, True))

    def test_generate_keeps_the_surface_unless_sizes_are_given(self):
        surface, out = self.path("s.mesh"), self.path("g.mesh")
        verts, tris = surface_only(self.verts, self.tris)
        write_mesh(surface, verts, [], tris)
        for options, kept in (((), True), (("--size-max", "0.2"), False), (("--size-max", "0.2", "--keep-surface"), True)):
            done = self.done(1, "generate", surface, "-o", out, *options)
            self.assertEqual(len(read_rows(out, "Triangles", 4)) == len(tris), kept, options)
            self.assertEqual("surface triangulation is kept" in done.out, options == ())

    def assert_close(self, a, b):
        for name in a:
            if isinstance(a[name], dict):
                self.assert_close(a[name], b[name])
            elif not isinstance(a[name], list):
                self.assertAlmostEqual(a[name], b[name], delta=1e-12 * max(1, abs(a[name])), msg=name)

    def test_convert(self):
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                binary, text, vtu = self.path("x.meshb"), self.path("x.mesh"), self.path("x.vtu")
                self.done(ranks, "convert", self.good, binary)
                self.done(ranks, "convert", binary, text)
                self.done(ranks, "convert", text, vtu)
                self.assertEqual(self.assert_valid_cube(text)["tets"], len(self.tets))
                self.done(ranks, "convert", self.metric, self.path("x.solb"))
                self.done(ranks, "convert", self.path("x.solb"), self.path("x.sol"))
                self.assertEqual(self.json(1, "stats", text, "--metric", self.path("x.sol")),
                                 self.json(1, "stats", self.good, "--metric", self.metric))

    def test_partition(self):
        for ranks in RANKS:
            with self.subTest(ranks=ranks):
                out = self.path("p.meshb")
                told = self.json(ranks, "partition", self.good, "--parts", "3", "-o", out)
                self.assertGreater(told["cut_faces"], 0)
                self.assertLess(told["imbalance"], 0.1)
                self.assertGreaterEqual(told["components"], 3)
                self.assertIn("seconds", told)
                self.assert_valid_cube(out)
                again = self.json(1, "partition", self.good, "--parts", "1")
                self.assertEqual((again["cut_faces"], again["components"]), (0, 1))


if __name__ == "__main__":
    unittest.main()
