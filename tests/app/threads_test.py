"""The number of threads: where it comes from, and that only this number changes the result, whatever OpenMP gives."""
import json
import os
import unittest

from runner import Case, cube, isotropic, run, write_mesh, write_solution

NAMES = ("OMP_NUM_THREADS", "OMP_THREAD_LIMIT", "OMP_DYNAMIC", "OMP_MAX_ACTIVE_LEVELS", "OMP_PROC_BIND", "OMP_PLACES")
SETTINGS = ({"OMP_NUM_THREADS": "2"}, {"OMP_NUM_THREADS": "2,1"}, {"OMP_THREAD_LIMIT": "1"}, {"OMP_DYNAMIC": "true"},
            {"OMP_MAX_ACTIVE_LEVELS": "1"}, {"OMP_NUM_THREADS": "4", "OMP_PROC_BIND": "true"})


class Threads(Case):
    def setUp(self):
        super().setUp()
        self.verts, self.tets, self.tris = cube(12)  # enough for four blocks
        write_mesh(self.good, self.verts, self.tets, self.tris)
        write_solution(self.metric, [isotropic(0.05)] * len(self.verts))

    def adapt(self, ranks, setting, *options):
        """The bytes of the result, and the number of threads that the report tells."""
        out, report = self.path("out.meshb"), self.path("out.json")
        prefix = ["env", *(f"--unset={name}" for name in NAMES), *(f"{name}={value}" for name, value in setting.items())]
        result = run(ranks, "adapt", self.good, "--metric", self.metric, "-o", out, "--report", report, "--rounds", "1",
                     *options, prefix=prefix, limit=120)
        self.assertEqual(result.code, 0, (setting, result.out, result.err))
        with open(report, encoding="utf-8") as f:
            threads = json.load(f)["threads"]
        with open(out, "rb") as f:
            return f.read(), threads, result.out

    def test_only_the_number_of_threads_changes_the_result(self):
        results = [self.adapt(1, {}, "--threads", threads)[0] for threads in (1, 2, 4)]
        self.assertEqual(len(set(results)), 3, "the mesh is too small: threads make no difference")
        for threads, settings in ((1, SETTINGS[:1]), (2, SETTINGS), (4, SETTINGS[:3])):
            for setting in settings:
                with self.subTest(threads=threads, **setting):
                    got, told, _ = self.adapt(1, setting, "--threads", threads)
                    self.assertEqual(told, threads)
                    self.assertTrue(got == results[threads // 2])

    def test_the_environment_gives_the_default(self):
        for value, threads in ((None, 1), ("2", 2), ("4,2", 4), ("nonsense", 1)):
            with self.subTest(OMP_NUM_THREADS=value):
                setting = {} if value is None else {"OMP_NUM_THREADS": value}
                got, told, _ = self.adapt(1, setting)
                self.assertEqual(told, threads)
                self.assertTrue(got == self.adapt(1, {}, "--threads", threads)[0])

    def test_more_threads_than_cores_on_two_ranks(self):
        got, told, _ = self.adapt(2, {"OMP_NUM_THREADS": "4"})
        self.assertEqual(told, 4)
        self.assertTrue(got == self.adapt(2, {"OMP_THREAD_LIMIT": "1"}, "--threads", "4")[0])

    def test_places_that_are_too_few_are_told(self):
        first = min(os.sched_getaffinity(0))
        _, _, out = self.adapt(1, {"OMP_PLACES": f"{{{first}}}"}, "--threads", "2")
        self.assertIn("2 threads share 1 core,", out)

    @unittest.skipIf(len(os.sched_getaffinity(0)) < 2, "one core")
    def test_binding_is_not_mistaken_for_too_few_cores(self):
        _, _, out = self.adapt(1, {"OMP_PROC_BIND": "true"}, "--threads", "2")
        self.assertNotIn("share", out)


if __name__ == "__main__":
    unittest.main()
