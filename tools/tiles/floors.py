# SPDX-License-Identifier: Apache-2.0
"""Parquet, and leather from seeded noise: sheets that cover the cell."""
import math

from base import Surface, tile

OAK, WALNUT = ((0.50, 0.30, 0.13), 0.0, 0.45), ((0.27, 0.13, 0.06), 0.0, 0.4)


@tile("fishbone", "herringbone parquet: eight planks in each cell, twice as long as wide, with round edges", 0.03125,
      {"along": OAK, "across": WALNUT}, covering=True, parameters={"edge": (0.0625, 0.0078125, 0.09375)})
def fishbone(edge=0.015625):
    """edge is the width of the rounding. The cell is a board of 4 x 4 squares; a plank along u covers squares (k, k)
    and (k + 1, k), one along v (k + 3, k) and (k + 3, k + 1). Each square is modelled for itself: the cell's border
    passes between squares, not through planks."""
    parts = {"along": [], "across": []}
    sides = [(0, -1), (1, 0), (0, 1), (-1, 0)]  # below, right, above, left, from corner k to corner k + 1
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    def square(x, y, goes_on, patches):  # goes_on: the side beyond which the plank has its other half
        inset = [0 if k == goes_on else 4 * edge for k in range(4)]
        outer = [((x + i) / 4, (y + j) / 4) for i, j in corners]
        inner = [((x + (inset[3] if i == 0 else 1 - inset[1])) / 4, (y + (inset[0] if j == 0 else 1 - inset[2])) / 4)
                 for i, j in corners]
        for k in range(4):
            n = (k + 1) % 4
            if k != goes_on:
                patches.append(Surface([[outer[i] + (0,), outer[i] + (1,), inner[i] + (1,)] for i in (k, n)], (1, 2)))
        a, b, c, d = [p + (1,) for p in inner]
        patches.append(Surface([[a, d], [b, c]], (1, 1)))
    for k in range(4):
        square(k, k, sides.index((1, 0)), parts["along"])
        square((k + 1) % 4, k, sides.index((-1, 0)), parts["along"])
        square((k + 3) % 4, k, sides.index((0, 1)), parts["across"])
        square((k + 3) % 4, (k + 1) % 4, sides.index((0, -1)), parts["across"])
    return {name: [s.in_cell(1.0) for s in patches] for name, patches in parts.items()}


def noise(seed, *numbers):
    """A number in [0, 1) that depends on the seed and the whole numbers alone: SplitMix64."""
    h = seed
    for n in numbers:
        h = (h + (n + 1) * 0x9E3779B97F4A7C15) & (2**64 - 1)
        h = ((h ^ h >> 30) * 0xBF58476D1CE4E5B9) & (2**64 - 1)
        h = ((h ^ h >> 27) * 0x94D049BB133111EB) & (2**64 - 1)
        h ^= h >> 31
    return h / 2**64


LEATHER = dict(seed=12, spans=20, grains=5)


@tile("leather", "leather: pebbled grain, a smooth height field from seeded noise", 0.0625,
      {"leather": ((0.20, 0.075, 0.03), 0.0, 0.5)}, covering=True, parameters={"crease": (0.25, 0.125, 1.0)})
def leather(crease=1.0):
    """crease is the depth of the creases, as part of the height. One grain lies about a random point in each square
    of a board of 5 x 5; the height falls where the second nearest grain is hardly farther than the nearest, and
    carries some value noise. These are the control points of a C1 quadratic spline, periodic in u and v."""
    n, m, seed = LEATHER["spans"], LEATHER["grains"], LEATHER["seed"]
    def height(i, j):
        u, v = (i + 0.5) / n * m, (j + 0.5) / n * m
        near = []
        for x in range(math.floor(u) - 2, math.floor(u) + 3):
            for y in range(math.floor(v) - 2, math.floor(v) + 3):
                px, py = [c + 0.05 + 0.9 * noise(seed, k, x % m, y % m) for k, c in enumerate((x, y))]
                near.append((math.hypot(u - px, v - py), noise(seed, 2, x % m, y % m)))
        near.sort()
        rise = min(1.0, (near[1][0] - near[0][0]) / 0.4)
        grain = rise * (2 - rise) * (0.8 + 0.2 * near[0][1])
        return (1 - crease) + crease * (0.94 * grain + 0.06 * noise(seed, 3, i, j))
    net = [[((i + 0.5) / n, (j + 0.5) / n, height(i, j)) for j in range(n)] for i in range(n)]
    return {"leather": [Surface(net, cyclic=((1, 0, 0), (0, 1, 0))).in_cell(1.0)]}
