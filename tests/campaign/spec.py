"""What a case is made of. All follows from its seed; `SEED:key=value:key=value` changes some of it.

Keys: n (voxels, as 3x2x2), sub (cells per voxel and direction), cut (kuhn, five), field, density, regions, paint, tris,
sheets, lines, points (numbers of those that are there, as 0.2), req (kinds that are required, as tri.edge), share (how
many of these), drop (voxels taken away), torn (where vertices are doubled), jitter, affine, bend (0 or 1), first (number
of the first region), size, complexity (at most), extra (an option), again (1: the result is adapted once more, to coarse
sizes), same (1: the same run twice must give the same bytes), ranks, threads, rounds.
"""
import hashing

FIELDS = ("bodies", "bodies", "regions", "regions", "layers", "solid", "holes")
PAINTS = ("sides", "one", "random", "region", "plain")
TRIS = ("all", "all", "all", "hull", "inner", "half", "none")
SIZES = ("uniform", "fine", "coarse", "linear", "jump", "stretched", "thin", "turning", "keep")
TORN = ("no", "no", "no", "no", "regions", "slit")
EXTRA = ("no", "no", "no", "no", "surface", "chapter", "quick", "graded", "free")
REQUIRED = ("vert", "edge", "tri", "tet")
LISTS = ("sheets", "lines", "points", "drop")
WORDS = {"cut": ("kuhn", "five"), "field": FIELDS, "paint": PAINTS, "tris": TRIS, "size": SIZES, "torn": TORN,
         "extra": EXTRA}


def draw(seed):
    """The case of a seed, as a dict."""
    r = hashing.stream("case", seed)
    n = [r.choice((1, 2, 2, 3)) for _ in range(3)]
    n[0] = max(2, n[0])
    spec = {"seed": seed, "n": n, "sub": r.choice((1, 1, 2, 2)), "cut": r.choice(("kuhn", "kuhn", "five"))}
    if n[0] * n[1] * n[2] == 27:
        spec["sub"] = 1
    spec["field"] = r.choice(FIELDS)
    spec["density"] = r.choice((0.35, 0.5, 0.65, 0.85))
    spec["regions"] = r.choice((1, 2, 3, 5))
    spec["paint"] = r.choice(PAINTS)
    spec["tris"] = r.choice(TRIS)
    spec["sheets"] = list(range(r.choice((0, 0, 1, 2, 3))))
    spec["lines"] = list(range(r.choice((0, 0, 1, 2, 4))))
    spec["points"] = list(range(r.choice((0, 0, 1, 3))))
    spec["req"] = [kind for kind in REQUIRED if r.random() < 0.22]
    spec["share"] = r.choice((0.02, 0.1, 0.1, 0.4, 1.0))
    spec["drop"] = []
    spec["jitter"] = int(r.random() < 0.5)
    spec["affine"] = int(r.random() < 0.5)
    spec["bend"] = int(r.random() < 0.2)
    spec["size"] = r.choice(SIZES)
    spec["ranks"] = r.choice((1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 6, 8))
    spec["threads"] = r.choice((1, 1, 1, 2, 2, 3, 4))
    spec["rounds"] = r.choice((1, 2, 3, 3))
    spec["torn"] = r.choice(TORN)
    spec["first"] = r.choice((1, 1, 1, 0, -4, 30000))
    spec["complexity"] = r.choice((60, 250, 250, 250, 800))
    spec["extra"] = r.choice(EXTRA)
    spec["again"] = int(r.random() < 0.2)
    spec["same"] = int(r.random() < 0.2)
    tidy(spec)
    return spec


def tidy(spec):
    """A crack is legal where both sides are in the list of triangles, and only as long as they match: each side is then
    adapted by itself."""
    if spec["torn"] != "no":
        spec["tris"], spec["again"] = "all", 0


def parse(text):
    """The case that a text names; ValueError when it names none."""
    seed, *changes = text.split(":")
    spec = draw(int(seed))
    for change in changes:
        key, sign, value = change.partition("=")
        if not sign or key not in spec or key == "seed":
            raise ValueError(f"a case has no {change!r}")
        spec[key] = parse_value(key, value)
    return spec


def parse_value(key, value):
    if key == "n":
        return [int(v) for v in value.split("x")]
    if key in LISTS:
        return [int(v) for v in value.split(".") if v]
    if key == "req":
        return [v for v in value.split(".") if v]
    if key in WORDS:
        if value not in WORDS[key]:
            raise ValueError(f"{key} is one of {', '.join(sorted(set(WORDS[key])))}")
        return value
    return float(value) if key == "density" or key == "share" else int(value)


def write(spec):
    """The shortest text that parse() makes this case of."""
    drawn, words = draw(spec["seed"]), [str(spec["seed"])]
    for key, value in spec.items():
        if value != drawn[key]:
            sep = "x" if key == "n" else "."
            words.append(f"{key}=" + (sep.join(map(str, value)) if isinstance(value, list) else str(value)))
    return ":".join(words)
