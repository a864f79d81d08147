"""Makes a failing case smaller, as long as it fails in the same way."""
import time

import running
import voxels


def size(outcome):
    """Orders outcomes: those that are easiest to look at first."""
    spec = outcome.spec
    extras = sum(len(spec[key]) for key in ("sheets", "lines", "points", "req"))
    return spec["ranks"] > 1, spec["threads"] > 1, outcome.before.get("tetrahedra", 0), extras


def simpler(spec):
    """Smaller cases, the most promising first: each a dict of changes."""
    for ranks in sorted({1, 2, 3, spec["ranks"] // 2}):
        if 0 < ranks < spec["ranks"]:
            yield {"ranks": ranks}
    for threads in (1, 2):
        if threads < spec["threads"]:
            yield {"threads": threads}
    for key in ("sheets", "lines", "points", "req"):
        yield from ({key: part} for part in shorter(spec[key]))
    for key in ("again", "same", "jitter", "affine", "bend"):
        if spec[key]:
            yield {key: 0}
    if spec["sub"] > 1:
        yield {"sub": 1}
    numbers = present(spec)
    for part in shorter(numbers):
        if part:
            yield {"drop": sorted(set(spec["drop"]) | (set(numbers) - set(part)))}
    if spec["rounds"] > 1:
        yield {"rounds": 1}
    for key, value in (("torn", "no"), ("extra", "no"), ("first", 1), ("complexity", 60), ("regions", 1), ("paint", "one"), ("tris", "all"), ("size", "uniform"), ("cut", "kuhn")):
        if spec[key] != value:
            yield {key: value}


def present(spec):
    """Numbers of the voxels that are there."""
    n = spec["n"]
    return sorted((i * n[1] + j) * n[2] + k for i, j, k in voxels.voxel_regions(spec))


def shorter(items):
    """Parts of a list to try instead: nothing, halves, all but one."""
    if not items:
        return
    yield []
    half = len(items) // 2
    if half:
        yield items[:half]
        yield items[half:]
    if len(items) > 2:
        for i in range(len(items)):
            yield items[:i] + items[i + 1:]


def reduce(outcome, wanted, program, seconds):
    """The smallest outcome with a fault of the kind `wanted` that is found within some time."""
    best, end = outcome, time.monotonic() + seconds
    tried, again = set(), True
    while again and time.monotonic() < end:
        again = False
        for change in simpler(best.spec):
            if time.monotonic() > end:
                break
            spec = {**best.spec, **change}
            if repr(spec) in tried:
                continue
            tried.add(repr(spec))
            found = running.run(spec, program)
            if wanted in found.kinds:
                best, again = found, True
                break
    return best
