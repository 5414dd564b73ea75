# SPDX-License-Identifier: Apache-2.0
"""Chain mail."""
from base import Surface, square, tile

RING, WIRE, LINK, LINK_WIRE = 0.3984375, 0.078125, (0.296875, 0.1875), 0.0625
ASPECT = 0.5  # twice the link's half height, wire included


def ring(wire):
    return Surface([[(0.5 + x * (RING + e), 0.5 + y * (RING + e), z) for e, z in square(WIRE * wire)]
                    for x, y in square(1.0)], cyclic=(True, True))


def half_link(wire):
    """The half at u <= 1 of the link about (1, .5), from the top of the plane u = 1 to its bottom."""
    half, height = LINK
    path = [(0, 1), (-1, 1), (-1, -1), (0, -1)]
    return Surface([[(1 + x * (half + e), 0.5 + y, z * (height + e)) for e, y in square(LINK_WIRE * wire)]
                    for x, z in path], cyclic=(False, True)).reversed()


@tile("chain", "chain mail: a flat ring in each cell, joined to all four neighbours by upright links", ASPECT,
      {"ring": ((1.0, 0.71, 0.29), 1.0, 0.22), "link": ((0.96, 0.64, 0.49), 1.0, 0.26)},
      parameters={"wire": (0.5, 0.25, 1.0)})
def chain(wire=1.0):
    """Japanese four-in-one mail: flat rings joined by upright links; wire scales its radius."""
    z0 = -ASPECT / 2
    right = half_link(wire)
    left = right.map(lambda p: (1 - p[0], p[1], p[2])).reversed()
    turn = lambda p: (p[1], p[0], p[2])
    links = [right, left, right.map(turn).reversed(), left.map(turn).reversed()]
    return {"ring": [ring(wire).in_cell(ASPECT, z0)], "link": [s.in_cell(ASPECT, z0) for s in links]}
