"""Compares a mesh with the one that it was made from. Shares no code with Skein.

check(before, after) gives a list of faults, each a pair of a kind and a sentence; the gravest kinds first.
"""
from dataclasses import dataclass

import numpy as np

import measures
import topology
import validity


@dataclass
class Tolerance:
    """How far sizes may differ, relatively. Flat domains keep them but for rounding."""
    volume: float = 1e-9
    area: float = 1e-9
    length: float = 1e-9

    def of(self, kind):
        return self.volume if kind == "region" else self.area if kind == "patch" else self.length


FLAT = Tolerance()
BENT = Tolerance(0.05, 0.08, 0.08)


def rows_in(wanted, there):
    """For each row of `wanted` the number of an equal row (bit by bit) in `there`, or -1."""
    index = {row.tobytes(): i for i, row in enumerate(there)}
    return np.array([index.get(row.tobytes(), -1) for row in wanted], int)


def places(rows):
    """Coordinates with -0 as 0, one contiguous row per vertex."""
    return np.ascontiguousarray(rows + 0.0)


class Comparison:
    """One mesh before, one after."""

    def __init__(self, before, after, tolerance):
        self.before, self.after, self.tolerance = before, after, tolerance
        self.faces = [topology.Faces(mesh.tets) for mesh in (before, after)]
        known = np.unique(before.refs["Triangles"])
        self.parts = [measures.Complex(m, f, known) for m, f in zip((before, after), self.faces)]
        self.found = []
        # vertices may share their place, as on both sides of a slit: each stands for the last of them
        here = places(after.coords)
        self.place = rows_in(here, here)
        self.same_vertex = rows_in(places(before.coords), here)

    def tell(self, kind, text):
        self.found.append((kind, text))

    def sizes(self):
        """Volumes, areas and lengths; Euler characteristics and pieces."""
        was, now = {}, {}
        for found, mesh, parts in zip((was, now), (self.before, self.after), self.parts):
            for part in (measures.regions(mesh), measures.patches(mesh, parts), measures.seams(mesh, parts),
                         measures.lines(mesh)):
                found.update(part)
        for name in sorted(set(was) | set(now), key=str):
            kind, what = name
            if name not in now or name not in was:
                self.tell(f"{kind}.{'new' if name in now else 'gone'}", f"{kind} {what}: {was.get(name)} -> {now.get(name)}")
                continue
            if abs(was[name][0] - now[name][0]) > self.tolerance.of(kind) * max(was[name][0], now[name][0]):
                self.tell(f"{kind}.size", f"{kind} {what}: {was[name][0]:.12g} -> {now[name][0]:.12g}")
            if was[name][1:] != now[name][1:]:
                self.tell(f"{kind}.topology", f"{kind} {what}: Euler characteristic and pieces {was[name][1:]} -> "
                                              f"{now[name][1:]}")

    def triangles(self):
        """Every hull face and face between regions has a triangle, where that was so before."""
        if not len(self.parts[0].bare) and len(self.parts[1].bare):
            self.tell("patch.bare", f"{len(self.parts[1].bare)} faces of the hull or between regions have no triangle")

    def ridges(self):
        was, now = measures.ridge_length(self.before), measures.ridge_length(self.after)
        most = measures.ridge_length(self.before, measures.possible_ridges(self.before, self.parts[0]))
        for ref in sorted(set(was) | set(now)):
            length, got = was.get(ref, 0), now.get(ref, 0)
            # the program finds further ridges; where the file has no edge, they have the reference 0
            if got < length * (1 - self.tolerance.length) or (
                    ref != 0 and got > most.get(ref, 0) * (1 + self.tolerance.length)):
                self.tell("ridge.size", f"ridges of reference {ref}: {length:.12g} -> {got:.12g}")

    def corners(self):
        which = measures.corners(self.before, self.parts[0], self.faces[0])
        lost = which[self.same_vertex[which] < 0]
        if len(lost):
            self.tell("corner.gone", f"{len(lost)} of {len(which)} corners are not in their place, first vertex {lost[0] + 1}")

    def vertex_lists(self):
        for name in ("Corners", "RequiredVertices"):
            which = self.before.lists[name]
            now = self.same_vertex[which]
            if (now < 0).any():
                self.tell(f"{name}.gone", f"{(now < 0).sum()} of {len(which)} {name} are not in their place, first vertex "
                                          f"{which[now < 0][0] + 1}")
            which, now = which[now >= 0], now[now >= 0]
            self.listed(name, which, now)
            there = set(zip(self.place.tolist(), self.after.refs["Vertices"].tolist()))
            wanted = zip(now.tolist(), self.before.refs["Vertices"][which].tolist())
            other = np.array([pair not in there for pair in wanted], bool)
            if other.any():
                self.tell(f"{name}.reference", f"{other.sum()} {name} changed their reference, first {which[other][0] + 1}")

    def listed(self, name, which, now):
        self.tell_unlisted(name, which, ~np.isin(now, self.place[self.after.lists[name]]))

    def tell_unlisted(self, name, which, missing):
        if missing.any():
            self.tell(f"{name}.unlisted", f"{missing.sum()} of {len(which)} are there, but not in {name}, first "
                                          f"{which[missing][0] + 1}")

    def required(self, name, cells_name):
        """Required edges, triangles or tetrahedra: same places, same reference, listed."""
        which = self.before.lists[name]
        if not len(which):
            return
        cells = self.before.cells[cells_name][which]
        now = self.same_vertex[cells]
        there = {}
        for i, row in enumerate(self.place[self.after.cells[cells_name]].tolist()):
            there.setdefault(tuple(sorted(row)), []).append(i)
        numbers = [there.get(tuple(sorted(row)), []) for row in now.tolist()]
        gone = np.array([not found for found in numbers], bool)
        if gone.any():
            self.tell(f"{name}.gone", f"{gone.sum()} of {len(which)} {name} are gone, first number {which[gone][0] + 1}")
        which, numbers = which[~gone], [found for found in numbers if found]
        listed = set(self.after.lists[name].tolist())
        self.tell_unlisted(name, which, np.array([listed.isdisjoint(found) for found in numbers], bool))
        refs = self.after.refs[cells_name]
        other = np.array([self.before.refs[cells_name][i] not in refs[found] for i, found in zip(which, numbers)], bool)
        if other.any():
            self.tell(f"{name}.reference", f"{other.sum()} {name} changed their reference, first {which[other][0] + 1}")


def check(before, after, tolerance=FLAT):
    """All that is wrong with the mesh `after`, made from `before`."""
    if not len(after.tets):
        return [("empty", "no tetrahedra")]
    found = validity.references(after)
    if found:
        return found
    comparison = Comparison(before, after, tolerance)
    found = validity.whole(after, comparison.faces[1])
    comparison.sizes()
    comparison.triangles()
    comparison.ridges()
    comparison.corners()
    comparison.vertex_lists()
    for name, cells in (("RequiredEdges", "Edges"), ("RequiredTriangles", "Triangles"),
                        ("RequiredTetrahedra", "Tetrahedra")):
        comparison.required(name, cells)
    return found + comparison.found
