"""Fields of voxels, and the tetrahedra that they are cut into."""
import itertools

import numpy as np

import hashing
import topology

FIVE = (((0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)), ((1, 0, 0), (0, 0, 0), (1, 1, 0), (1, 0, 1)),
        ((0, 1, 0), (0, 0, 0), (1, 1, 0), (0, 1, 1)), ((0, 0, 1), (0, 0, 0), (1, 0, 1), (0, 1, 1)),
        ((1, 1, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1)))


def kuhn():
    """Six tetrahedra along the diagonal of the cell, one for each order of the axes."""
    for order in itertools.permutations(range(3)):
        corner, tet = [0, 0, 0], [(0, 0, 0)]
        for axis in order:
            corner[axis] = 1
            tet.append(tuple(corner))
        yield tuple(tet)


KUHN = tuple(kuhn())


def five(cell):
    """Five tetrahedra, turned over in every other cell, so that the faces of neighbours fit."""
    if sum(cell) % 2 == 0:
        return FIVE
    return tuple(tuple((1 - x, y, z) for x, y, z in tet) for tet in FIVE)


def voxel_regions(spec):
    """Region of each voxel (i, j, k) that is there; regions count from 1."""
    n, seed = spec["n"], spec["seed"]
    found = {}
    for number, voxel in enumerate(itertools.product(*map(range, n))):
        if number in spec["drop"]:
            continue
        some = hashing.unit(seed, "fill", voxel) < spec["density"]
        any_region = 1 + int(hashing.unit(seed, "region", voxel) * spec["regions"])
        region = {"bodies": any_region if some else 0, "regions": any_region, "solid": 1,
                  "layers": 1 + voxel[0] % max(2, spec["regions"]),
                  "holes": any_region if some or sum(voxel) % 2 else 0}[spec["field"]]
        if region:
            found[voxel] = region
    if not found:
        left = [i for i in range(n[0] * n[1] * n[2]) if i not in spec["drop"]]
        if left:
            found[list(itertools.product(*map(range, n)))[left[0]]] = 1
    return found


def tetrahedra(spec):
    """Places of the vertices on the lattice, tetrahedra, their regions. The numbers of vertices follow the lattice."""
    sub, places, tets, regions = spec["sub"], {}, [], []
    for voxel, region in voxel_regions(spec).items():
        for offset in itertools.product(range(sub), repeat=3):
            cell = tuple(sub * v + o for v, o in zip(voxel, offset))
            for tet in KUHN if spec["cut"] == "kuhn" else five(cell):
                corners = [tuple(c + t for c, t in zip(cell, corner)) for corner in tet]
                tets.append([places.setdefault(corner, len(places)) for corner in corners])
                regions.append(region)
    lattice = np.array(list(places), int).reshape(-1, 3)
    tets = np.array(tets, int).reshape(-1, 4)
    turned = topology.volumes6(lattice.astype(float), tets) < 0
    tets[turned, 2], tets[turned, 3] = tets[turned, 3].copy(), tets[turned, 2].copy()
    return tear(spec, lattice, tets, np.array(regions, int))


def tear(spec, lattice, tets, regions):
    """Doubles vertices: where bodies touch in edges and vertices only, between regions, or along a slit. Both sides then
    are hull, in the same place."""
    if spec["torn"] == "no" or not len(tets):
        return lattice, tets, regions
    faces = topology.Faces(tets)
    joined = faces.second >= 0
    if spec["torn"] == "regions":
        joined &= regions[faces.first // 4] == regions[faces.second // 4]
    if spec["torn"] == "slit":
        r = hashing.stream(spec["seed"], "slit")
        axis, other = r.sample(range(3), 2)
        at = r.randint(1, max(1, spec["sub"] * spec["n"][axis] - 1))
        low = r.choice((0, 0.4)) * spec["sub"] * spec["n"][other]
        places = lattice[faces.verts]
        joined &= ~((places[:, :, axis] == at).all(axis=1) & (places[:, :, other].mean(axis=1) >= low))
    labels = topology.corner_labels(tets, faces, joined)
    roots, numbers = np.unique(labels, return_inverse=True)
    return lattice[tets.ravel()[roots]], numbers.reshape(-1, 4), regions
