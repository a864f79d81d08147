"""What a case names besides its tetrahedra: painted faces, sheets, lines, points, required entities."""
import numpy as np

import hashing
import topology

SHEET_REF, LINE_REF, POINT_REF, EDGE_REF, BETWEEN_REF = 100, 200, 300, 400, 50


class Features:
    """Collects triangles, edges and lists for one mesh. Names of things are places on the lattice, which stay when
    voxels go."""

    def __init__(self, spec, lattice, mesh):
        self.spec, self.lattice, self.mesh = spec, lattice, mesh
        self.seed = spec["seed"]
        self.faces = topology.Faces(mesh.tets)
        regions = mesh.refs["Tetrahedra"]
        both = self.faces.second >= 0
        self.hull = ~both
        self.low = regions[self.faces.first // 4]
        self.high = np.where(both, regions[self.faces.second // 4], 0)
        self.between = both & (self.low != self.high)
        self.face_ref = np.full(len(self.faces.key), -1)  # -1: no triangle
        self.edge_ref = {}
        self.ridges = set()
        self.all_edges = np.unique(np.sort(mesh.tets[:, topology.TET_EDGES].reshape(-1, 2), axis=1), axis=0)

    def name(self, verts):
        return tuple(sorted(tuple(p) for p in self.lattice[verts].tolist()))

    def chance(self, what, verts):
        return hashing.unit(self.seed, what, self.name(verts))

    def paint(self):
        """References of the hull and of the faces between regions, for as many of them as `tris` says."""
        tris, paint = self.spec["tris"], self.spec["paint"]
        for f in np.flatnonzero(self.hull | self.between):
            verts = self.faces.verts[f]
            if tris == "none" or (tris == "half" and self.chance("painted", verts) < 0.5):
                continue
            if (tris == "hull" and not self.hull[f]) or (tris == "inner" and self.hull[f]):
                continue
            place = self.lattice[verts]
            axis = int(np.argmax((place == place[0]).all(axis=0)))
            low, high = sorted((int(self.low[f]), int(self.high[f])))
            self.face_ref[f] = {"sides": 1 + axis if self.hull[f] else BETWEEN_REF + axis, "one": 1,
                                "random": 1 + int(3 * self.chance("paint", verts)),
                                "region": 10 + high if self.hull[f] else BETWEEN_REF + 8 * low + high,
                                "plain": 7 if self.hull[f] else 0}[paint]

    def sheet(self, number):
        """Sheet `number`: inner faces of one region with a reference of their own."""
        r = hashing.stream(self.seed, "sheet", number)
        free = np.flatnonzero(~self.hull & ~self.between & (self.face_ref < 0))
        if not len(free):
            return
        kind = r.choice(("plane", "ragged", "cross", "diagonal", "walk", "fan", "crumbs"))
        ref = SHEET_REF + (0 if r.random() < 0.2 else number)
        places = self.lattice[self.faces.verts[free]]
        if kind == "walk":
            chosen = self.walk_faces(free, number, r.randint(2, 12))
        elif kind == "fan":
            chosen = self.fan_faces(free, number, r.randint(3, 6))
        elif kind == "crumbs":
            chosen = [f for f in free if self.chance(("crumb", number), self.faces.verts[f]) < 0.04]
        else:
            inside = self.plane(r, places, kind)
            if kind == "cross":
                inside |= self.plane(r, places, kind)
            chosen = free[inside]
            if kind == "ragged":
                chosen = [f for f in chosen if self.chance(("ragged", number), self.faces.verts[f]) < 0.7]
        self.face_ref[chosen] = ref

    def plane(self, r, places, kind):
        """Which faces lie in a random rectangle of a lattice plane."""
        size = [n * self.spec["sub"] for n in self.spec["n"]]
        axis = r.randrange(3)
        if kind == "diagonal":
            level = places[:, :, axis] - places[:, :, (axis + 1) % 3]
            at = r.choice((-1, 0, 0, 1))
        else:
            level = places[:, :, axis]
            at = r.randint(1, max(1, size[axis] - 1))
        inside = (level == at).all(axis=1)
        for other in {0, 1, 2} - {axis}:
            low = r.choice((0, 0, r.randint(0, size[other])))
            high = r.choice((size[other], r.randint(low, size[other])))
            middle = places[:, :, other].mean(axis=1)
            inside &= (middle >= low) & (middle <= max(high, low + 1))
        return inside

    def fan_faces(self, free, number, count):
        """Faces round one or two edges: three or more sheets at an edge."""
        edges = np.unique(np.sort(self.faces.verts[free][:, topology.TRI_EDGES].reshape(-1, 2), axis=1), axis=0).tolist()
        edges.sort(key=lambda edge: self.chance(("fan", number), edge))
        chosen = []
        for a, b in edges[:1 + number % 2]:
            verts = self.faces.verts[free]
            near = free[(verts == a).any(axis=1) & (verts == b).any(axis=1)].tolist()
            chosen += sorted(near, key=lambda f: self.chance(("leaf", number), self.faces.verts[f]))[:count]
        return chosen

    def walk_faces(self, free, number, count):
        """A chain of faces, each with an edge in common with one before."""
        order = {f: self.chance(("walk", number), self.faces.verts[f]) for f in free.tolist()}
        chosen = [min(order, key=order.get)]
        while len(chosen) < count:
            have = [set(self.faces.verts[f].tolist()) for f in chosen]
            near = [f for f in order if f not in chosen
                    and any(len(s.intersection(self.faces.verts[f].tolist())) == 2 for s in have)]
            if not near:
                break
            chosen.append(min(near, key=order.get))
        return chosen

    def line(self, number):
        """Line `number`: a chain of mesh edges, through the volume, on the hull or straight on."""
        r = hashing.stream(self.seed, "line", number)
        kind, count = r.choice(("any", "hull", "straight", "loop", "star")), r.randint(1, 8)
        edges = self.all_edges
        if kind == "hull":
            edges = np.unique(np.sort(self.faces.verts[self.hull][:, topology.TRI_EDGES].reshape(-1, 2), axis=1), axis=0)
        ref = LINE_REF + number
        ridge = r.random() < 0.5
        near = {}
        for a, b in edges.tolist():
            near.setdefault(a, []).append(b)
            near.setdefault(b, []).append(a)
        at = min(near, key=lambda v: self.chance(("start", number), [v]))
        if kind in ("loop", "star"):
            around = sorted(near[at], key=lambda v: self.chance(("ray", number), [at, v]))
            if kind == "loop":
                around = [around[0], next((v for v in around[1:] if v in near[around[0]]), around[0])]
                self.add_edge(around, ref, ridge)
            for v in around[:count + 1]:
                self.add_edge((at, v), ref, ridge)
            return
        seen, step = {at}, None
        for _ in range(count):
            to = [v for v in near[at] if v not in seen]
            if kind == "straight" and step is not None:
                to = [v for v in to if tuple(self.lattice[v] - self.lattice[at]) == step]
            if not to:
                break
            then = min(to, key=lambda v: self.chance(("step", number), [at, v]))
            step = tuple(self.lattice[then] - self.lattice[at])
            self.add_edge((at, then), ref, ridge)
            seen.add(then)
            at = then

    def add_edge(self, verts, ref, ridge):
        """One edge of a line; lines that were there before keep theirs."""
        edge = (min(verts), max(verts))
        if edge not in self.edge_ref and edge[0] != edge[1]:
            self.edge_ref[edge] = ref
            if ridge:
                self.ridges.add(edge)

    def finish(self):
        """Puts triangles and points into the mesh, and the required ones into their lists. Edges come later."""
        spec, mesh = self.spec, self.mesh
        for number in spec["points"]:
            r = hashing.stream(self.seed, "point", number)
            v = min(range(len(mesh.coords)), key=lambda v: self.chance(("point", number), [v]))
            mesh.refs["Vertices"][v] = POINT_REF + number
            name = r.choice(("RequiredVertices", "RequiredVertices", "Corners"))
            mesh.lists[name] = np.union1d(mesh.lists[name], [v])
        tagged = np.flatnonzero(self.face_ref >= 0)
        mesh.set_cells("Triangles", self.faces.verts[tagged], self.face_ref[tagged])
        some = lambda what, cells: [i for i, c in enumerate(cells) if self.chance(what, c) < spec["share"]]
        if "tri" in spec["req"]:
            mesh.lists["RequiredTriangles"] = np.array(some("required", mesh.tris), int)
        if "tet" in spec["req"]:
            mesh.lists["RequiredTetrahedra"] = np.array(some("required", mesh.tets), int)
        if "vert" in spec["req"]:
            some_verts = some("required", np.arange(len(mesh.coords))[:, None])
            mesh.lists["RequiredVertices"] = np.union1d(mesh.lists["RequiredVertices"], some_verts).astype(int)
        if "edge" in spec["req"]:
            for edge in self.all_edges.tolist():
                if self.chance("loose", edge) < 0.2 * spec["share"]:
                    self.edge_ref.setdefault(tuple(edge), EDGE_REF)

    def put_edges(self):
        """Puts edges, ridges and required edges into the mesh."""
        mesh, spec = self.mesh, self.spec
        edges = sorted(self.edge_ref)
        mesh.set_cells("Edges", edges, [self.edge_ref[e] for e in edges])
        mesh.lists["Ridges"] = np.array([i for i, e in enumerate(edges) if e in self.ridges], int)
        if "edge" in spec["req"]:
            chosen = [i for i, e in enumerate(edges) if self.edge_ref[e] == EDGE_REF
                      or (self.edge_ref[e] > 0 and self.chance("required", list(e)) < spec["share"])]
            mesh.lists["RequiredEdges"] = np.array(chosen, int)
