"""What a mesh consists of, counted with numpy: faces, edges, components, Euler characteristics, feature edges."""
import numpy as np

# the faces of a tetrahedron, counter-clockwise seen from outside; face i is opposite vertex i
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])
TRI_EDGES = np.array([[0, 1], [1, 2], [2, 0]])
TET_EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])


def keys(rows):
    """One number per row of up to four vertex numbers, the same for every order of them (numbers below 2^20 each, or
    2^15 for rows of four)."""
    rows = np.sort(rows, axis=1)
    bits = 15 if rows.shape[1] == 4 else 20
    if rows.size and rows.max() >> bits:
        raise ValueError("too many vertices")
    found = np.zeros(len(rows), np.int64)
    for column in rows.T:
        found = (found << bits) | column
    return found


def components(count, a, b):
    """Label of each of `count` nodes that links a[i] - b[i] join: the least node of its component."""
    label = np.arange(count)
    if not len(a):
        return label
    while True:
        least = np.minimum(label[a], label[b])
        new = label.copy()
        np.minimum.at(new, label[a], least)
        np.minimum.at(new, label[b], least)
        while not np.array_equal(new[new], new):
            new = new[new]
        new = new[label]
        if np.array_equal(new, label):
            return label
        label = new


def component_count(cells):
    """Pieces of a set of cells (rows of vertices) that share vertices."""
    if not len(cells):
        return 0
    used, local = np.unique(cells, return_inverse=True)
    local = local.reshape(cells.shape)
    a = np.repeat(local[:, 0], cells.shape[1] - 1)
    return len(np.unique(components(len(used), a, local[:, 1:].ravel())))


def euler(cells):
    """Euler characteristic of a set of edges, triangles or tetrahedra with all their sides."""
    if not len(cells):
        return 0
    verts = len(np.unique(cells))
    if cells.shape[1] == 2:
        return verts - len(cells)
    pairs = TRI_EDGES if cells.shape[1] == 3 else TET_EDGES
    edges = len(np.unique(keys(cells[:, pairs].reshape(-1, 2))))
    if cells.shape[1] == 3:
        return verts - edges + len(cells)
    faces = len(np.unique(keys(cells[:, FACES].reshape(-1, 3))))
    return verts - edges + faces - len(cells)


def lengths(coords, edges):
    return np.linalg.norm(coords[edges[:, 0]] - coords[edges[:, 1]], axis=1)


def area_vectors(coords, tris):
    a, b, c = (coords[tris[:, i]] for i in range(3))
    return np.cross(b - a, c - a) / 2


def areas(coords, tris):
    return np.linalg.norm(area_vectors(coords, tris), axis=1)


def volumes6(coords, tets):
    a = coords[tets[:, 0]]
    b, c, d = (coords[tets[:, i]] - a for i in (1, 2, 3))
    return np.einsum("ij,ij->i", np.cross(b, c), d)


class Faces:
    """The faces of the tetrahedra. Per distinct face: `verts`, `count` (tetrahedra), `first` and `second` (side
    numbers 4 * tetrahedron + i; second is -1 on the hull), `key` (sorted)."""

    def __init__(self, tets):
        sides = tets[:, FACES].reshape(-1, 3)
        all_keys = keys(sides)
        order = np.argsort(all_keys, kind="stable")
        self.key, start, self.count = np.unique(all_keys[order], return_index=True, return_counts=True)
        self.first = order[start] if len(order) else start
        self.second = np.where(self.count > 1, order[np.minimum(start + 1, max(len(order) - 1, 0))], -1)
        self.verts = sides[self.first] if len(order) else np.zeros((0, 3), int)
        self.sides = sides

    def find(self, tris):
        """Index of each triangle among the faces; -1: it is no face."""
        if not len(self.key):
            return np.full(len(tris), -1)
        wanted = keys(tris)
        at = np.minimum(np.searchsorted(self.key, wanted), len(self.key) - 1)
        return np.where(self.key[at] == wanted, at, -1)


def corner_labels(tets, faces, joined):
    """A label for each corner of a tetrahedron (number 4 * tetrahedron + i). Two corners in one vertex have the same if a
    way leads round the vertex from one to the other through `joined` faces."""
    both = joined & (faces.second >= 0)
    links_a, links_b = [], []
    first, second = faces.first[both], faces.second[both]
    for corner in range(3):
        vert = faces.sides[first, corner]
        a = 4 * (first // 4) + np.argmax(tets[first // 4] == vert[:, None], axis=1)
        b = 4 * (second // 4) + np.argmax(tets[second // 4] == vert[:, None], axis=1)
        links_a.append(a)
        links_b.append(b)
    return components(tets.size, np.concatenate(links_a), np.concatenate(links_b))


def pieces_at_vertices(coords_count, tets, faces):
    """How many fans of tetrahedra joined by faces each vertex has. Two or more: bodies touch in this vertex or edge."""
    label = corner_labels(tets, faces, np.ones(len(faces.key), bool))
    roots = label == np.arange(tets.size)
    return np.bincount(tets.ravel()[roots], minlength=coords_count)


def feature_edges(tris, refs):
    """The edges of a complex of triangles where other than two triangles of one reference meet. Returns the edges and
    for each its signature: the sorted references of its triangles, as a tuple."""
    edges = tris[:, TRI_EDGES].reshape(-1, 2)
    of = np.repeat(refs, 3)
    key = keys(edges)
    order = np.lexsort((of, key))
    distinct, start, count = np.unique(key[order], return_index=True, return_counts=True)
    low = np.minimum.reduceat(of[order], start) if len(start) else start
    high = np.maximum.reduceat(of[order], start) if len(start) else start
    special = np.flatnonzero((count != 2) | (low != high))
    found = np.sort(edges[order[start[special]]], axis=1) if len(special) else np.zeros((0, 2), int)
    return found, [tuple(of[order[start[i]:start[i] + count[i]]].tolist()) for i in special]
