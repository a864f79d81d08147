"""What a mesh is, apart from how it is cut into elements: volumes, areas, lengths; Euler characteristics and pieces."""
import numpy as np

import topology

HULL, BETWEEN, SHEET = 0, 1, 2
PLACES = ("hull", "between regions", "sheet")
UNNAMED = -1  # reference of faces that the file gives no triangle for


class Complex:
    """The faces that matter: the hull, faces between regions, faces with a triangle. `label` is 4 * reference + place.
    References that are not in `known` are the program's own and count as unnamed."""

    def __init__(self, mesh, faces, known):
        regions = mesh.refs["Tetrahedra"]
        both = faces.second >= 0
        between = both & (regions[faces.first // 4] != regions[faces.second // 4])
        ref = np.full(len(faces.key), UNNAMED)
        tagged = np.zeros(len(faces.key), bool)
        at = faces.find(mesh.tris)
        tagged[at[at >= 0]] = True
        ref[at[at >= 0]] = np.where(np.isin(mesh.refs["Triangles"], known), mesh.refs["Triangles"], UNNAMED)[at >= 0]
        place = np.where(~both, HULL, np.where(between, BETWEEN, SHEET))
        which = np.flatnonzero(tagged | (place != SHEET))
        self.bare = np.flatnonzero(~tagged & (place != SHEET))
        self.tris, self.label = faces.verts[which], (4 * ref + place)[which]


def label_name(label):
    ref = label // 4
    return f"{'unnamed' if ref == UNNAMED else 'reference %d' % ref}, {PLACES[label % 4]}"


def add(found, name, cells, measure):
    """`found[name]` gets size, Euler characteristic and number of pieces of some cells."""
    found[name] = (float(measure.sum()), topology.euler(cells), topology.component_count(cells))


def regions(mesh):
    """Per region reference, and of all tetrahedra: volume, Euler characteristic, pieces."""
    found, volume = {}, topology.volumes6(mesh.coords, mesh.tets) / 6
    refs = mesh.refs["Tetrahedra"]
    for ref in np.unique(refs).tolist():
        add(found, ("region", ref), mesh.tets[refs == ref], volume[refs == ref])
    add(found, ("region", "all"), mesh.tets, volume)
    return found


def patches(mesh, parts):
    """Per label, of the hull, and of all faces that matter: area, Euler characteristic, pieces."""
    found, area = {}, topology.areas(mesh.coords, parts.tris)
    for label in np.unique(parts.label).tolist():
        add(found, ("patch", label_name(label)), parts.tris[parts.label == label], area[parts.label == label])
    hull = parts.label % 4 == HULL
    add(found, ("patch", "hull"), parts.tris[hull], area[hull])
    add(found, ("patch", "all"), parts.tris, area)
    return found


def seams(mesh, parts):
    """Per signature of edges where other than two faces of one label meet (rims, seams, junctions, contacts): length,
    Euler characteristic, pieces."""
    edges, signatures = topology.feature_edges(parts.tris, parts.label)
    found, length = {}, topology.lengths(mesh.coords, edges)
    numbers = {}
    which = np.array([numbers.setdefault(s, len(numbers)) for s in signatures], int)
    for signature, number in numbers.items():
        name = " | ".join(label_name(label) for label in signature)
        if len(signature) > 3 and len(set(signature)) == 1:
            name = f"{len(signature)} of {name}"
        kind = "rim" if len(signature) == 1 else "seam" if len(signature) == 2 else "junction"
        if len(signature) > 2 and all(label % 4 == HULL for label in signature):
            kind = "contact"
        add(found, (kind, name), edges[which == number], length[which == number])
    return found


def lines(mesh):
    """Per reference of edges (but 0, which the program gives to ridges that it finds): length, Euler characteristic,
    pieces."""
    found, refs = {}, mesh.refs["Edges"]
    length = topology.lengths(mesh.coords, mesh.edges)
    for ref in np.unique(refs[refs != 0]).tolist():
        add(found, ("line", ref), mesh.edges[refs == ref], length[refs == ref])
    return found


def ridge_length(mesh, which=None):
    """Per reference: length of ridges, or of the edges `which`."""
    which = mesh.lists["Ridges"] if which is None else which
    refs, length = mesh.refs["Edges"][which], topology.lengths(mesh.coords, mesh.edges[which])
    return {ref: float(length[refs == ref].sum()) for ref in np.unique(refs).tolist()}


def possible_ridges(mesh, parts):
    """Numbers of the edges that are ridges, or that the program finds to be such: on folds and where patches meet."""
    found = {tuple(e) for e in topology.feature_edges(parts.tris, parts.label)[0].tolist()}
    found |= {tuple(e) for e in folds(mesh, parts)}
    on_fold = [i for i, e in enumerate(np.sort(mesh.edges, axis=1).tolist()) if tuple(e) in found]
    return np.union1d(mesh.lists["Ridges"], on_fold).astype(int)


def corners(mesh, parts, faces):
    """Vertices that can be nowhere else: those listed, ends, branches and sharp bends of feature lines, vertices where
    bodies touch in one point."""
    seam, signature = topology.feature_edges(parts.tris, parts.label)
    names = {}
    for edge, name in zip(map(tuple, seam.tolist()), signature):
        names[edge] = (name, None)
    for edge in map(tuple, folds(mesh, parts)):
        names.setdefault(edge, (None, None))
    for edge, ref in zip(np.sort(mesh.edges, axis=1).tolist(), mesh.refs["Edges"].tolist()):
        # a ridge of reference 0 is as one that the program finds
        names[tuple(edge)] = (names.get(tuple(edge), (None,))[0], ref or None)
    at = {}
    for (a, b), name in names.items():
        at.setdefault(a, []).append((b, name))
        at.setdefault(b, []).append((a, name))
    found = set(mesh.lists["Corners"].tolist()) | set(mesh.lists["RequiredVertices"].tolist())
    for v, ends in at.items():
        if len(ends) != 2 or ends[0][1] != ends[1][1]:
            found.add(v)
            continue
        p, q = mesh.coords[v] - mesh.coords[ends[0][0]], mesh.coords[ends[1][0]] - mesh.coords[v]
        if p @ q < 0.5 * np.linalg.norm(p) * np.linalg.norm(q):
            found.add(v)
    touching = np.flatnonzero(topology.pieces_at_vertices(len(mesh.coords), mesh.tets, faces) > 1)
    return np.array(sorted(found | {v for v in touching.tolist() if v not in at}), int)


def folds(mesh, parts):
    """Edges of exactly two faces of one label that are folded by more than 50 degrees."""
    vectors = topology.area_vectors(mesh.coords, parts.tris)
    vectors = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    half = parts.tris[:, topology.TRI_EDGES].reshape(-1, 2)
    key = topology.keys(half)
    order = np.argsort(key, kind="stable")
    _, start, count = np.unique(key[order], return_index=True, return_counts=True)
    one, two = order[start[count == 2]], order[start[count == 2] + 1]
    same = parts.label[one // 3] == parts.label[two // 3]
    one, two = one[same], two[same]
    sign = np.where(half[one, 0] == half[two, 1], 1.0, -1.0)
    cosine = sign * np.einsum("ij,ij->i", vectors[one // 3], vectors[two // 3])
    return np.sort(half[one[cosine < np.cos(np.radians(50))]], axis=1).tolist()
