#!/usr/bin/env python3
"""Stands for a flow solver: a steep layer on the vertices of a mesh, and how well the mesh carries it.

    solve.py MESH.mesh SOLUTION.sol

Writes the solution and prints the tetrahedra and the error of its linear interpolation, in the L2 norm.
"""
import math
import sys


def layer(x, y, z):
    """Jumps from -1 to 1 across the sphere of radius 0.7 round the origin."""
    return math.tanh(40 * (math.sqrt(x * x + y * y + z * z) - 0.7))


def read(path):
    with open(path, encoding="ascii") as f:
        words = f.read().split()

    def rows(keyword, width):
        at = words.index(keyword)
        n = int(words[at + 1])
        return [words[at + 2 + width * i:at + 2 + width * (i + 1)] for i in range(n)]

    verts = [tuple(map(float, row[:3])) for row in rows("Vertices", 4)]
    tets = [tuple(int(v) - 1 for v in row[:4]) for row in rows("Tetrahedra", 5)]
    return verts, tets


def error(verts, tets, values):
    """Four points in each tetrahedron, each near one of its vertices: exact for squares of linear functions."""
    near, far = 0.5854101966249685, 0.1381966011250105
    total = 0.0
    for tet in tets:
        x = [verts[v] for v in tet]
        a, b, c = ([x[k][i] - x[0][i] for i in range(3)] for k in (1, 2, 3))
        volume = abs(a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                     + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6
        for k in range(4):
            weight = [near if j == k else far for j in range(4)]
            point = [sum(w * p[i] for w, p in zip(weight, x)) for i in range(3)]
            linear = sum(w * values[v] for w, v in zip(weight, tet))
            total += volume / 4 * (linear - layer(*point)) ** 2
    return math.sqrt(total)


def main():
    verts, tets = read(sys.argv[1])
    values = [layer(*x) for x in verts]
    with open(sys.argv[2], "w", encoding="ascii") as f:
        f.write(f"MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n{len(values)}\n1 1\n")
        f.writelines(f"{v!r}\n" for v in values)
        f.write("End\n")
    print(f"{len(tets)} tetrahedra, error {error(verts, tets, values):.5f}")


main()
