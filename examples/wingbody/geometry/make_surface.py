#!/usr/bin/python3
"""Makes the surface triangulation of the wing-body half model: gmsh's OpenCASCADE kernel, sizes from sources.toml.

    make_surface.py [OUT.meshb]        needs Debian's python3-gmsh (and numpy); the result is kept in the repository

The fuselage lies along x (nose at 0, tail at 30), the half span along y, z is up, and y = 0 is the symmetry plane.
References of the triangles: 1 symmetry, 2 far field, 3 fuselage, 4 wing upper side, 5 wing lower side, 6 wing tip.
"""
import math
import struct
import sys
import tomllib
from pathlib import Path

import gmsh

HERE = Path(__file__).resolve().parent
SYMMETRY, FAR_FIELD, FUSELAGE, UPPER, LOWER, TIP = 1, 2, 3, 4, 5, 6

LENGTH, RADIUS = 30.0, 1.75  # fuselage
NOSE, TAIL = 5.0, 19.0  # end of the ogive, begin of the taper
SPAN, ROOT_CHORD, TAPER = 15.0, 7.0, 0.3  # chord at y = 0, inside the fuselage
ROOT_AT = (10.0, -0.60)  # x and z of the leading edge at y = 0
SWEEP, DIHEDRAL = math.radians(28.0), math.radians(4.0)  # of the leading edge
THICKNESS, CAMBER, CAMBER_AT = 0.12, 0.015, 0.4  # of the aerofoil, over the chord
FAR_RADIUS = 10 * LENGTH


def nose_profile(theta):
    """von Karman ogive; theta = 0 at the tip, pi at its end."""
    x = 0.5 * NOSE * (1 - math.cos(theta))
    return x, RADIUS * math.sqrt(max(0.0, theta - 0.5 * math.sin(2 * theta)) / math.pi)


def tail_profile(theta):
    """Taper to a rounded tip; theta = 0 at its begin, pi / 2 at the tip."""
    return TAIL + (LENGTH - TAIL) * math.sin(theta), RADIUS * max(0.0, math.cos(theta)) ** 1.2


def aerofoil(t, side):
    """Point of a NACA four-digit section with a sharp trailing edge, chord 1; t = 0 leading edge, 1 trailing edge."""
    x = 0.5 * (1 - math.cos(math.pi * t))
    half = 5 * THICKNESS * (0.2969 * math.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    p, c = CAMBER_AT, CAMBER
    camber = c / p**2 * (2 * p * x - x * x) if x < p else c / (1 - p) ** 2 * (1 - 2 * p + 2 * p * x - x * x)
    return x, camber + side * half


def leading_edge(y):
    return ROOT_AT[0] + y * math.tan(SWEEP), ROOT_AT[1] + y * math.tan(DIHEDRAL)


def chord(y):
    return ROOT_CHORD * (1 + (TAPER - 1) * y / SPAN)


# ---------------------------------------------------------------------------------------------------- geometry
def make_fuselage(occ):
    """Half of the body of revolution, y >= 0."""
    n = 24
    nose = [occ.addPoint(x, 0, r) for x, r in (nose_profile(math.pi * i / n) for i in range(n + 1))]
    tail = [occ.addPoint(x, 0, r) for x, r in (tail_profile(0.5 * math.pi * i / n) for i in range(n + 1))]
    wire = [occ.addSpline(nose), occ.addLine(nose[-1], tail[0]), occ.addSpline(tail), occ.addLine(tail[-1], nose[0])]
    face = occ.addPlaneSurface([occ.addCurveLoop(wire)])
    solids = occ.revolve([(2, face)], 0, 0, 0, 1, 0, 0, -math.pi)  # from +z over +y to -z
    return [s for s in solids if s[0] == 3]


def make_wing(occ):
    """Straight loft between the section on the symmetry plane, which lies inside the fuselage, and the tip."""
    wires = []
    n = 32
    for y in (0.0, SPAN):
        (x0, z0), c = leading_edge(y), chord(y)
        upper = [occ.addPoint(x0 + c * x, y, z0 + c * z) for x, z in (aerofoil(i / n, +1) for i in range(n + 1))]
        lower = [occ.addPoint(x0 + c * x, y, z0 + c * z) for x, z in (aerofoil(i / n, -1) for i in range(1, n))]
        sides = [occ.addSpline(upper), occ.addSpline([upper[-1], *reversed(lower), upper[0]])]
        wires.append(occ.addCurveLoop(sides))
    return [s for s in occ.addThruSections(wires, makeSolid=True, makeRuled=True) if s[0] == 3]


def make_domain(occ):
    """The fluid: half a ball without the wing-body."""
    ball = occ.addSphere(LENGTH / 2, 0, 0, FAR_RADIUS, angle3=math.pi)  # y >= 0
    body, _ = occ.fuse(make_fuselage(occ), make_wing(occ))
    fluid, _ = occ.cut([(3, ball)], body)
    occ.synchronize()
    return fluid


def reference(face):
    """Which patch a face of the fluid is, from its place."""
    x0, y0, z0, x1, y1, z1 = gmsh.model.getBoundingBox(2, face)
    if y1 < 1e-3:
        return SYMMETRY
    if y1 > SPAN + 1:
        return FAR_FIELD
    if y0 > SPAN - 1e-3:
        return TIP
    if y1 < SPAN - 1:
        return FUSELAGE
    # upper or lower wing: side of the camber line at mid span
    (u0, v0), (u1, v1) = gmsh.model.getParametrizationBounds(2, face)
    point = gmsh.model.getValue(2, face, [(u0 + u1) / 2, (v0 + v1) / 2])
    (xl, zl), c = leading_edge(point[1]), chord(point[1])
    s = (point[0] - xl) / c
    t = math.acos(1 - 2 * s) / math.pi
    middle = zl + c * (aerofoil(t, 1)[1] + aerofoil(t, -1)[1]) / 2
    return UPPER if point[2] > middle else LOWER


# ---------------------------------------------------------------------------------------------------- sizes
def distance_to_segment(p, a, b):
    ab = [b[i] - a[i] for i in range(3)]
    ap = [p[i] - a[i] for i in range(3)]
    length2 = sum(v * v for v in ab)
    t = min(1.0, max(0.0, sum(u * v for u, v in zip(ab, ap)) / length2)) if length2 > 0 else 0.0
    return math.sqrt(sum((ap[i] - t * ab[i]) ** 2 for i in range(3)))


class Spacing:
    """The isotropic spacing of point and line sources."""

    def __init__(self, path):
        table = tomllib.loads(Path(path).read_text())
        self.cap = table.get("size_max", math.inf)
        self.sources = [(s["at"], s["at"], s["spacing"], s["r1"], s["r2"]) for s in table.get("point", [])]
        self.sources += [(s["from"], s["to"], s["spacing"], s["r1"], s["r2"]) for s in table.get("line", [])]

    def __call__(self, p):
        size = self.cap
        for a, b, spacing, r1, r2 in self.sources:
            beyond = max(0.0, distance_to_segment(p, a, b) - r1) / (r2 - r1)
            if beyond < 30:
                size = min(size, spacing * 2**beyond)
        return size


# ---------------------------------------------------------------------------------------------------- mesh
def triangulate(spacing):
    option = gmsh.option.setNumber
    option("Mesh.MeshSizeExtendFromBoundary", 0)
    option("Mesh.MeshSizeFromPoints", 0)
    option("Mesh.MeshSizeFromCurvature", 0)
    option("Mesh.Algorithm", 6)  # frontal Delaunay
    option("Mesh.Smoothing", 5)
    option("General.NumThreads", 1)
    gmsh.model.mesh.setSizeCallback(lambda dim, tag, x, y, z: spacing((x, y, z)))
    gmsh.model.mesh.generate(2)


def collect():
    """Coordinates and (a, b, c, reference), vertices numbered from 0 in the order of their first use."""
    tags, flat, _ = gmsh.model.mesh.getNodes()
    place = {int(t): tuple(flat[3 * i : 3 * i + 3]) for i, t in enumerate(tags)}
    number, coords, triangles = {}, [], []
    for _, face in gmsh.model.getEntities(2):
        ref = reference(face)
        _, nodes = gmsh.model.mesh.getElementsByType(2, face)
        for i in range(0, len(nodes), 3):
            triangle = []
            for node in map(int, nodes[i : i + 3]):
                if node not in number:
                    number[node] = len(coords)
                    x, y, z = place[node]
                    coords.append((x, 0.0 if abs(y) < 1e-9 else y, z))
                triangle.append(number[node])
            triangles.append((*triangle, ref))
    return coords, triangles


def orient(coords, triangles):
    """Turns all triangles so that their normals point out of the fluid; every edge must have two triangles."""
    edges = {}
    for i, t in enumerate(triangles):
        for k in range(3):
            edges.setdefault(frozenset((t[k], t[(k + 1) % 3])), []).append(i)
    if any(len(e) != 2 for e in edges.values()):
        raise SystemExit("the triangulation is not closed")
    done, out = {0: triangles[0]}, [0]
    while out:
        i = out.pop()
        t = done[i]
        for k in range(3):
            a, b = t[k], t[(k + 1) % 3]
            for j in edges[frozenset((a, b))]:
                if j in done:
                    continue
                u = triangles[j]
                same = any(u[m] == a and u[(m + 1) % 3] == b for m in range(3))
                done[j] = (u[0], u[2], u[1], u[3]) if same else u
                out.append(j)
    result = [done[i] for i in range(len(triangles))]
    volume = 0.0
    for a, b, c, _ in result:
        p, q, r = coords[a], coords[b], coords[c]
        volume += p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) + p[2] * (q[0] * r[1] - q[1] * r[0])
    return result if volume > 0 else [(a, c, b, ref) for a, b, c, ref in result]


def write_meshb(path, coords, triangles):
    """GMF, version 2: double precision, 32-bit positions."""
    data = bytearray(struct.pack("<2i", 1, 2))

    def section(keyword, count, payload):
        data.extend(struct.pack("<3i", keyword, len(data) + 12 + len(payload), count) + payload)

    section(3, 3, b"")
    section(4, len(coords), b"".join(struct.pack("<3di", *p, 0) for p in coords))
    section(6, len(triangles), b"".join(struct.pack("<4i", a + 1, b + 1, c + 1, ref) for a, b, c, ref in triangles))
    data.extend(struct.pack("<2i", 54, 0))
    Path(path).write_bytes(data)


def main():
    out = sys.argv[1] if len(sys.argv) > 1 else str(HERE.parent / "surface.meshb")
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    make_domain(gmsh.model.occ)
    triangulate(Spacing(HERE.parent / "sources.toml"))
    coords, triangles = collect()
    gmsh.finalize()
    triangles = orient(coords, triangles)
    write_meshb(out, coords, triangles)
    patches = {ref: sum(t[3] == ref for t in triangles) for ref in sorted({t[3] for t in triangles})}
    print(f"{out}: {len(coords)} vertices, {len(triangles)} triangles, per reference {patches}")


if __name__ == "__main__":
    main()
