"""The checker finds planted faults, and none in meshes that keep everything."""
import copy
import random
import sys
import tempfile
import unittest
from fractions import Fraction

import numpy as np

import checker
import generator
import medit
import spec as specs
import topology
import validity

PLAIN = "n=2x2x2:sub=2:cut=kuhn:field=layers:density=1:regions=2:paint=sides:tris=all:sheets=:lines=:points=:req=:share=0.5:" \
        "torn=no:first=1:complexity=250:extra=no:again=0:same=0:"\
        "jitter=0:affine=0:bend=0:size=keep"


def case(seed=1, **changes):
    """The mesh of a case: two regions in a box unless `changes` say otherwise."""
    spec = specs.parse(f"{seed}:{PLAIN}")
    for key, value in changes.items():
        spec[key] = specs.parse_value(key, value)
    return generator.build(spec)[0]


def split_edge(mesh, a, b):
    """A new mesh with a vertex in the middle of edge (a, b): nothing is lost."""
    new = copy.deepcopy(mesh)
    middle = len(mesh.coords)
    new.coords = np.vstack([mesh.coords, (mesh.coords[a] + mesh.coords[b]) / 2])
    new.refs["Vertices"] = np.append(mesh.refs["Vertices"], 0)
    for name in medit.WIDTHS:
        cells, refs = new.cells[name], new.refs[name]
        both = (cells == a).any(axis=1) & (cells == b).any(axis=1)
        other = cells[both].copy()
        cells[both] = np.where(cells[both] == b, middle, cells[both])
        other[other == a] = middle
        added = len(cells) + np.arange(both.sum())
        if name == "Edges":
            new.lists["Ridges"] = np.append(new.lists["Ridges"], added[np.isin(np.flatnonzero(both), new.lists["Ridges"])])
        new.set_cells(name, np.vstack([cells, other]), np.append(refs, refs[both]))
    return new


def two_cubes(offset):
    """Two cubes of one cell that touch where `offset` says, with triangles of reference 7."""
    lattice, tets = {}, []
    for cell in ((0, 0, 0), offset):
        for tet in generator.voxels.KUHN:
            corners = [tuple(c + t for c, t in zip(cell, corner)) for corner in tet]
            tets.append([lattice.setdefault(c, len(lattice)) for c in corners])
    mesh = medit.Mesh(np.array(list(lattice), float), tets, [1] * 12)
    turned = topology.volumes6(mesh.coords, mesh.tets) < 0
    mesh.tets[turned, 2], mesh.tets[turned, 3] = mesh.tets[turned, 3].copy(), mesh.tets[turned, 2].copy()
    faces = topology.Faces(mesh.tets)
    hull = faces.verts[faces.second < 0]
    mesh.set_cells("Triangles", hull, [7] * len(hull))
    return mesh


def pull_apart(mesh):
    """The second cube gets vertices of its own."""
    new = copy.deepcopy(mesh)
    shared = np.intersect1d(mesh.tets[:6], mesh.tets[6:])
    number = np.arange(len(mesh.coords))
    number[shared] = len(mesh.coords) + np.arange(len(shared))
    new.coords = np.vstack([mesh.coords, mesh.coords[shared]])
    new.refs["Vertices"] = np.zeros(len(new.coords), int)
    new.tets[6:] = number[mesh.tets[6:]]
    second = np.array([set(t) <= set(mesh.tets[6:].ravel().tolist()) for t in mesh.tris.tolist()])
    new.tris[second] = number[mesh.tris[second]]
    return new


class Planted(unittest.TestCase):
    def finds(self, kind, before, after):
        kinds = [k for k, _ in checker.check(before, after)]
        self.assertTrue(any(k.startswith(kind) for k in kinds), f"{kind} is not among {kinds}")

    def plant(self, kind, before, change):
        after = copy.deepcopy(before)
        change(after)
        self.finds(kind, before, after)

    def without(self, name, which):
        def change(mesh):
            keep = np.delete(np.arange(len(mesh.cells[name])), which)
            mesh.set_cells(name, mesh.cells[name][keep], mesh.refs[name][keep])
            for listed, named in medit.LISTS.items():
                if named == name:
                    old = mesh.lists[listed]
                    mesh.lists[listed] = np.searchsorted(keep, old[np.isin(old, keep)])
        return change

    def test_a_lost_tetrahedron(self):
        self.plant("region.size", case(), self.without("Tetrahedra", [0]))

    def test_a_tetrahedron_of_the_wrong_region(self):
        def change(mesh):
            mesh.refs["Tetrahedra"][0] = 3 - mesh.refs["Tetrahedra"][0]
        self.plant("region.size", case(), change)

    def test_a_turned_tetrahedron(self):
        def change(mesh):
            mesh.tets[5, :2] = mesh.tets[5, 1::-1].copy()
        self.plant("no-volume", case(), change)
        self.plant("same-side", case(), change)

    def test_a_doubled_tetrahedron(self):
        def change(mesh):
            mesh.set_cells("Tetrahedra", np.vstack([mesh.tets, mesh.tets[:1]]), np.append(mesh.refs["Tetrahedra"], 1))
        self.plant("face-of-three", case(), change)
        self.plant("twice", case(), change)

    def test_a_hull_vertex_off_its_plane(self):
        before = case()
        on_side = np.flatnonzero((before.coords[:, 2] == 0) & (before.coords[:, 0] == 0.5) & (before.coords[:, 1] == 0.5))

        def change(mesh):
            mesh.coords[on_side, 2] = -1e-4
        self.plant("patch.size", before, change)
        self.plant("region.size", before, change)

    def test_a_corner_that_moved_by_one_bit(self):
        def change(mesh):
            mesh.coords[mesh.coords[:, 0].argmax(), 0] = np.nextafter(mesh.coords[:, 0].max(), 9)
        self.plant("corner.gone", case(), change)

    def test_numbers_out_of_range(self):
        for name in medit.WIDTHS:
            before = case(lines="0.1")

            def change(mesh, name=name):
                mesh.cells[name][0, 0] = len(mesh.coords)
            self.plant("out-of-range", before, change)

    def test_list_numbers_out_of_range(self):
        def change(mesh):
            mesh.lists["RequiredTriangles"] = np.array([len(mesh.tris)])
        self.plant("out-of-range", case(), change)

    def test_a_coordinate_that_is_not_finite(self):
        def change(mesh):
            mesh.coords[3, 1] = np.nan
        self.plant("not-finite", case(), change)

    def test_a_vertex_of_no_tetrahedron(self):
        def change(mesh):
            mesh.coords = np.vstack([mesh.coords, [[0.1, 0.1, 0.1]]])
            mesh.refs["Vertices"] = np.append(mesh.refs["Vertices"], 0)
        self.plant("unused-vertex", case(), change)

    def test_required_triangles(self):
        before = case(req="tri")
        which = before.lists["RequiredTriangles"]
        self.assertGreater(len(which), 5)
        self.plant("RequiredTriangles.gone", before, self.without("Triangles", [which[2]]))

        def unlist(mesh):
            mesh.lists["RequiredTriangles"] = which[1:]

        def paint(mesh):
            mesh.refs["Triangles"][which[0]] += 1
        self.plant("RequiredTriangles.unlisted", before, unlist)
        self.plant("RequiredTriangles.reference", before, paint)

    def test_required_edges_vertices_tetrahedra(self):
        before = case(req="edge.vert.tet", lines="0.1.2")
        for name in ("RequiredEdges", "RequiredVertices", "RequiredTetrahedra"):
            which = before.lists[name]
            self.assertGreater(len(which), 1, name)

            def unlist(mesh, name=name, which=which):
                mesh.lists[name] = which[1:]
            self.plant(name + ".unlisted", before, unlist)
        for name, cells in (("RequiredEdges", "Edges"), ("RequiredTetrahedra", "Tetrahedra")):
            self.plant(name + ".gone", before, self.without(cells, [before.lists[name][0]]))
            edge = before.cells[cells][before.lists[name][0]]
            self.finds(name + ".gone", before, split_edge(before, edge[0], edge[1]))

    def test_a_lost_piece_of_a_line(self):
        self.plant("line.size", case(lines="0.1"), self.without("Edges", [0]))

    def test_ridges(self):
        before = case(lines="0.1.2.3", field="solid")
        before.lists["Ridges"] = np.array([0])
        self.plant("ridge.size", before, lambda mesh: mesh.lists.update(Ridges=np.zeros(0, int)))
        inner = np.flatnonzero(((before.coords > 0) & (before.coords < 2)).all(axis=1))
        inside = np.flatnonzero(np.isin(before.edges, inner).any(axis=1))
        self.assertGreater(len(inside[inside > 0]), 0)
        self.plant("ridge.size", before, lambda mesh: mesh.lists.update(Ridges=np.union1d([0], inside)))

    def test_a_lost_piece_of_a_rim(self):
        found = 0
        for seed in range(20):
            before = case(seed, sheets="0", field="solid")
            sheet = np.flatnonzero(before.refs["Triangles"] >= generator.features.SHEET_REF)
            if len(sheet) > 1:
                found += 1
                self.plant("patch.size", before, self.without("Triangles", [sheet[0]]))
                self.plant("rim", before, self.without("Triangles", [sheet[0]]))
        self.assertGreater(found, 5)

    def test_a_contact_that_is_pulled_apart(self):
        line, point = two_cubes((1, 1, 0)), two_cubes((1, 1, 1))
        self.assertEqual(checker.check(line, line), [])
        self.finds("contact.gone", line, pull_apart(line))
        self.finds("region.topology", line, pull_apart(line))
        self.finds("region.topology", point, pull_apart(point))

    def test_bodies_that_are_glued_together(self):
        line = two_cubes((1, 1, 0))
        self.finds("region.topology", pull_apart(line), line)

    def test_a_damaged_file(self):
        for text in ("Vertices\n3\n0 0 0 0\n", "Vertices\nx\n", "Nonsense\n1\n1\nEnd\n", "Vertices\n0\n"):
            with tempfile.NamedTemporaryFile("w", suffix=".mesh") as f:
                f.write(text)
                f.flush()
                with self.assertRaises(medit.BadFile):
                    medit.read_mesh(f.name)


class Sound(unittest.TestCase):
    def test_splitting_edges_loses_nothing(self):
        for seed in range(25):
            before = case(seed, sheets="0.1", lines="0.1", points="0", field="regions", regions="3", affine=str(seed % 2))
            after, r = before, random.Random(seed)
            for _ in range(12):
                tet = after.tets[r.randrange(len(after.tets))]
                after = split_edge(after, *r.sample(tet.tolist(), 2))
            self.assertEqual(checker.check(before, after), [], f"seed {seed}")

    def test_every_case_is_a_sound_mesh(self):
        for seed in range(100, 160):
            mesh, solution = generator.build(specs.draw(seed))
            self.assertEqual(checker.check(mesh, mesh), [], f"seed {seed}")
            self.assertEqual(len(solution), len(mesh.coords))
            self.assertTrue(np.isfinite(solution).all())

    def test_twins_on_both_sides_of_a_tear_are_told_apart(self):
        for torn in ("regions", "slit"):
            torn_mesh = case(3, torn=torn, field="bodies", density="0.6", regions="2", req="tri.edge.tet.vert", lines="0")
            self.assertEqual(checker.check(torn_mesh, torn_mesh), [], torn)
        one, two = case(3, field="layers"), case(3, field="layers", torn="regions")
        self.assertGreater(len(two.coords), len(one.coords))

    def test_a_case_is_its_text(self):
        for seed in range(50):
            spec = specs.draw(seed)
            spec.update(drop=[1, 2], sheets=[1], req=["tri"], n=[2, 3, 1], ranks=5)
            self.assertEqual(specs.parse(specs.write(spec)), spec)

    def test_signs_of_flat_tetrahedra_are_exact(self):
        r = np.random.default_rng(3)
        for _ in range(20):
            x = r.random((4, 3))
            x[3] = x[:3].T @ [0.5, 0.25, 0.25]
            got = len(validity.not_positive(medit.Mesh(x, [[0, 1, 2, 3]], [1]))) > 0
            rows = [[Fraction(float(v)) - Fraction(float(w)) for v, w in zip(x[i], x[0])] for i in (1, 2, 3)]
            det = sum(rows[0][i] * (rows[1][(i + 1) % 3] * rows[2][(i + 2) % 3] - rows[1][(i + 2) % 3] * rows[2][(i + 1) % 3])
                      for i in range(3))
            self.assertEqual(got, det <= 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv)
