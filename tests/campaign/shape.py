"""Where the vertices of a case lie, and the sizes that are wanted there."""
import numpy as np

import hashing
import topology


def rotation(r):
    """A random rotation."""
    q, upper = np.linalg.qr(np.array([[r.gauss(0, 1) for _ in range(3)] for _ in range(3)]))
    q = q * np.sign(np.diag(upper))
    return q if np.linalg.det(q) > 0 else -q


def affine(spec):
    """Matrix and shift: planes stay planes."""
    if not spec["affine"]:
        return np.eye(3), np.zeros(3)
    r = hashing.stream(spec["seed"], "affine")
    shear = np.eye(3)
    for i, j in ((0, 1), (0, 2), (1, 2)):
        shear[i, j] = r.choice((0, r.uniform(-0.8, 0.8)))
    stretch = np.diag([r.choice((1, 1, r.uniform(0.3, 3))) for _ in range(3)])
    matrix = r.choice((1.0, 1.0, 1e-3, 1e3)) * (rotation(r) if r.random() < 0.7 else np.eye(3)) @ shear @ stretch
    shift = np.array([r.uniform(-1, 1) for _ in range(3)]) * r.choice((0, 1, 100)) * np.linalg.norm(matrix)
    return matrix, shift


def bend(spec, x):
    """A smooth map of small slope."""
    if not spec["bend"]:
        return x
    r = hashing.stream(spec["seed"], "bend")
    size = max(spec["n"])
    y = x.copy()
    for axis in range(3):
        along = np.array([r.uniform(-1, 1) for _ in range(3)])
        y[:, axis] += 0.06 * size * np.sin(np.pi * (x @ along) / (size * np.abs(along).sum()) + r.uniform(0, 6))
    return y


def jitter(spec, lattice, x, tets, fixed):
    """Moves vertices that are not fixed, as far as all tetrahedra stay well positive."""
    if not spec["jitter"]:
        return x
    seed = spec["seed"]
    shift = np.array([[hashing.unit(seed, "jitter", tuple(p), axis) - 0.5 for axis in range(3)]
                      for p in lattice.tolist()]).reshape(-1, 3) / spec["sub"]
    shift[fixed] = 0
    for scale in (0.8, 0.5, 0.3, 0.1):
        moved = x + scale * shift
        if (topology.volumes6(moved, tets) > 0.02 / spec["sub"] ** 3).all():
            return moved
    return x


def place(spec, lattice, tets, fixed):
    """Coordinates of all vertices."""
    x = jitter(spec, lattice, lattice / spec["sub"], tets, fixed)
    matrix, shift = affine(spec)
    return bend(spec, x) @ matrix.T + shift


def lattice_metric(spec, lattice):
    """The wanted metric before the affine map: tensors, one per vertex, and whether they are isotropic."""
    seed, count = spec["seed"], len(lattice)
    r = hashing.stream(seed, "size")
    x = lattice / spec["sub"]
    kind = spec["size"]
    if kind in ("stretched", "thin", "turning"):
        aspect = 10 ** r.uniform(0.5, 3 if kind != "turning" else 1.3)
        h = np.diag([1, 1 if kind == "thin" else aspect ** r.uniform(0, 1), aspect])
        base = rotation(r)
        if kind == "turning":
            turns = [rotation(hashing.stream(seed, "turn", tuple(p))) for p in lattice.tolist()]
        else:
            turns = [base] * count
        d = np.linalg.inv(h) ** 2
        return np.array([q @ d @ q.T for q in turns]) * r.uniform(0.3, 3), False
    h = {"uniform": lambda: np.full(count, 10 ** r.uniform(-0.4, 0.6)), "fine": lambda: np.full(count, 0.3),
         "coarse": lambda: np.full(count, 30.0), "keep": lambda: np.full(count, 1.1 / spec["sub"]),
         "linear": lambda: 0.25 + x[:, r.randrange(3)] * r.uniform(0.2, 1.5),
         "jump": lambda: np.array([10 ** (hashing.unit(seed, "h", tuple(p)) - 0.5) for p in lattice.tolist()])}[kind]()
    return np.eye(3)[None] / h[:, None, None] ** 2, True


def coarse(spec, count):
    """Tensors for `count` vertices: edges as long as two voxels."""
    inverse = np.linalg.inv(affine(spec)[0])
    metric = inverse.T @ inverse / 4
    return np.repeat(metric[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]][None], count, axis=0)


def sizes(spec, lattice, x, tets):
    """The solution: sizes (one number per vertex) or tensors (six), scaled so that the case stays small."""
    metric, round_ = lattice_metric(spec, lattice)
    r = hashing.stream(spec["seed"], "solution")
    matrix, _ = affine(spec)
    as_sizes = round_ and r.random() < 0.5
    if as_sizes:
        metric = metric / abs(np.linalg.det(matrix)) ** (2 / 3)
    else:
        inverse = np.linalg.inv(matrix)
        metric = inverse.T @ metric @ inverse
    density = np.sqrt(np.linalg.det(metric))[tets]
    density = density.max(axis=1) if spec["size"] == "jump" else density.mean(axis=1)
    complexity = (topology.volumes6(x, tets) / 6 * density).sum()
    if complexity > spec["complexity"]:  # there will be about 12 times as many tetrahedra
        metric = metric * (spec["complexity"] / complexity) ** (2 / 3)
    if as_sizes:
        return 1 / np.sqrt(metric[:, 0, 0])
    return metric[:, [0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
