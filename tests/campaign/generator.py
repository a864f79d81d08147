"""Makes the mesh and the solution of a case."""
import numpy as np

import features
import medit
import shape
import topology
import voxels

# Skein keeps folds and bends of more than 45 degrees by itself. Those that are less, the file names.
NAMED_BELOW = np.cos(np.radians(50))


def build(spec):
    """Mesh, solution. The mesh may be empty, when all voxels are dropped."""
    lattice, tets, regions = voxels.tetrahedra(spec)
    mesh = medit.Mesh(lattice, tets, regions)
    if not len(tets):
        return mesh, None
    parts = features.Features(spec, lattice, mesh)
    parts.paint()
    for number in spec["sheets"]:
        parts.sheet(number)
    for number in spec["lines"]:
        parts.line(number)
    parts.finish()
    special = parts.hull | parts.between | (parts.face_ref >= 0)
    fixed = np.unique(np.concatenate([parts.faces.verts[special].ravel(), np.array(list(parts.edge_ref), int).ravel()]))
    mesh.coords = shape.place(spec, lattice, tets, fixed)
    name_shallow_folds(parts, special)
    parts.put_edges()
    mesh.refs["Tetrahedra"] += spec["first"] - 1
    name_shallow_bends(parts, special)
    return mesh, shape.sizes(spec, lattice, mesh.coords, mesh.tets)


def fold_edges(parts, special, coords):
    """Edges of exactly two faces of the complex with one reference: the edges, and the cosine of their fold in
    `coords` (1: flat)."""
    tris = parts.faces.verts[special]
    refs = parts.face_ref[special] - parts.between[special] * (parts.face_ref[special] < 0)
    normals = np.cross(coords[tris[:, 1]] - coords[tris[:, 0]], coords[tris[:, 2]] - coords[tris[:, 0]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    half = tris[:, topology.TRI_EDGES].reshape(-1, 2)
    order = np.argsort(topology.keys(half), kind="stable")
    _, start, count = np.unique(topology.keys(half)[order], return_index=True, return_counts=True)
    one, two = order[start[count == 2]], order[start[count == 2] + 1]
    same = refs[one // 3] == refs[two // 3]
    one, two = one[same], two[same]
    # neighbours turned the same way run along their edge in opposite directions
    sign = np.where(half[one, 0] == half[two, 1], 1.0, -1.0)
    return np.sort(half[one], axis=1), sign * np.einsum("ij,ij->i", normals[one // 3], normals[two // 3])


def name_shallow_folds(parts, special):
    """Folds of the lattice that are shallow now become ridges of the file."""
    edges, on_lattice = fold_edges(parts, special, parts.lattice.astype(float))
    _, now = fold_edges(parts, special, parts.mesh.coords)
    for edge in edges[(on_lattice < 0.999) & (now > NAMED_BELOW)].tolist():
        parts.edge_ref.setdefault(tuple(edge), 0)
        parts.ridges.add(tuple(edge))


def name_shallow_bends(parts, special):
    """Bends of feature lines on the lattice that are shallow now become corners of the file."""
    mesh = parts.mesh
    found, _ = topology.feature_edges(parts.faces.verts[special], parts.face_ref[special])
    folds, cosine = fold_edges(parts, special, parts.lattice.astype(float))
    lines = np.concatenate([found, folds[cosine < 0.999], mesh.edges])
    lines = np.unique(np.sort(lines, axis=1), axis=0)
    ends = np.concatenate([lines, lines[:, ::-1]])
    ends = ends[np.argsort(ends[:, 0], kind="stable")]
    verts, start, count = np.unique(ends[:, 0], return_index=True, return_counts=True)
    two = count == 2
    v, a, b = verts[two], ends[start[two], 1], ends[start[two] + 1, 1]

    def straightness(x):
        p, q = x[v] - x[a], x[b] - x[v]
        return np.einsum("ij,ij->i", p, q) / np.linalg.norm(p, axis=1) / np.linalg.norm(q, axis=1)

    bent = (straightness(parts.lattice.astype(float)) < 0.999) & (straightness(mesh.coords) > NAMED_BELOW)
    mesh.lists["Corners"] = np.union1d(mesh.lists["Corners"], v[bent]).astype(int)
