"""Random numbers that belong to things, not to the order in which they are drawn: the number of a voxel or of an edge
does not change when another voxel is taken away. This is what lets a failing case shrink."""
import hashlib
import random


def unit(*parts):
    """A number in [0, 1) that depends on the parts only."""
    digest = hashlib.blake2b(repr(parts).encode(), digest_size=8).digest()
    return int.from_bytes(digest, "big") / 2.0 ** 64


def stream(*parts):
    """A generator of random numbers that depends on the parts only."""
    return random.Random(repr(parts))
