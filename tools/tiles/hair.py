# SPDX-License-Identifier: Apache-2.0
"""Fur."""
import math
import random

from base import Surface, tile
from tubes import polygon

ACROSS = 6  # hairs
ASPECT = 1.0


@tile("fur", "fur: bent hairs, 36 in each cell, each a cone that ends in a point", ASPECT,
      {"hair": ((0.50, 0.31, 0.14), 0.0, 0.5)}, parameters={"length": (0.25, 0.1, 1.0), "bend": (0.0, 0.0, 1.0)})
def fur(length=1.0, bend=0.625):
    """Roots on a jittered grid; length scales the hairs, bend how far the tips lean: anyhow, and in the middle of the cell
    towards +u."""
    chance = random.Random(41)
    between = lambda a, b: a + (b - a) * chance.random()
    within = lambda lean, x: min(max(lean, 0.03 - x), 0.97 - x)
    hairs = []
    for i in range(ACROSS):
        for j in range(ACROSS):
            u, v = [0.025 + 0.95 * (k + between(0.05, 0.95)) / ACROSS for k in (i, j)]
            radius, high = between(0.018, 0.025), between(0.7, 1.0)
            lean = within(0.25 * math.sin(math.pi * u) + between(-0.15, 0.15), u), within(between(-0.2, 0.2), v)
            path = [(0, 0, 1.0), (0.2, 0.5, 0.85), (1, 1, 0)]  # share of the lean, of the length, of the radius
            hairs.append(Surface([[(u + bend * lean[0] * a + radius * c * x, v + bend * lean[1] * a + radius * c * y,
                                    length * high * b) for a, b, c in path] for x, y in polygon(3, 1.0)],
                                 cyclic=(True, False)))
    return {"hair": [s.in_cell(ASPECT) for s in hairs]}
