# SPDX-License-Identifier: Apache-2.0
"""Grips, walls and plates: sheets that cover the cell, most of them with creases."""
from base import Surface, mid, tile
from tubes import polygon

FLAT = (1, 1)
STEEL = ((0.55, 0.56, 0.58), 1.0, 0.32)


def flat(patches, a, b, c, d):
    """The bilinear patch with these corners, counterclockwise."""
    patches.append(Surface([[a, d], [b, c]], FLAT))


@tile("straight", "straight knurling: one ridge along v in each cell, with a flattened crest", 0.375,
      {"ridge": STEEL}, covering=True, parameters={"crest": (0.25, 0.0625, 0.375)})
def straight(crest=0.125):
    """crest is the width of the ridge's top."""
    profile = [(0, 0), (0.5 - crest / 2, 1), (0.5 + crest / 2, 1), (1, 0)]
    patches = []
    for (u, w), (u1, w1) in zip(profile, profile[1:]):
        flat(patches, (u, 0, w), (u1, 0, w1), (u1, 1, w1), (u, 1, w))
    return {"ridge": [s.in_cell(1.0) for s in patches]}


HEXAGON = ((0.25, 0.0), (0.25, 1 / 6), (0.0, 1 / 3))  # the first quarter: middle of a side, corner, corner


@tile("hexagon", "a grip of hexagonal pads with rounded rims, four in each cell", 0.125,
      {"pad": ((0.03, 0.03, 0.035), 0.0, 0.55)}, covering=True, parameters={"rim": (0.5, 0.125, 0.6)})
def hexagon(rim=0.25):
    """Two staggered rows; rim is how much of a pad's half width its rim takes. Quarters of pads, so that the cell's
    border passes between patches."""
    patches = []
    def quarter(u, v, x, y):
        at = lambda p, k, w: (u + x * p[0] * k, v + y * p[1] * k, w)
        def add(net, degree):
            s = Surface(net, degree)
            patches.append(s if x * y > 0 else s.reversed(0))
        for a, b in zip(HEXAGON, HEXAGON[1:]):  # outside to inside: steep first, level at the top
            add([[at(p, 1, 0), at(p, 1 - rim / 3, 1), at(p, 1 - rim, 1)] for p in (a, b)], (1, 2))
        top = [at(p, 1 - rim, 1) for p in HEXAGON]
        add([[(u, v, 1), top[2]], [top[0], top[1]]], FLAT)
    for x in (1, -1):
        for y in (1, -1):
            for u in (0.25, 0.75):
                quarter(u, 0 if y > 0 else 1, x, y)
            for u in (0 if x > 0 else 1, 0.5):
                quarter(u, 0.5, x, y)
    return {"pad": [s.in_cell(1.0) for s in patches]}


@tile("studs", "pyramid studs on leather, one in each cell", 0.375,
      {"leather": ((0.035, 0.02, 0.012), 0.0, 0.6), "stud": ((0.75, 0.74, 0.72), 1.0, 0.2)}, covering=True,
      parameters={"width": (0.5, 0.375, 0.9375), "top": (0.25, 0.03125, 0.3125)})
def studs(width=0.84375, top=0.03125):
    """width is that of a stud, top that of its flat tip."""
    rings = [[(0.5 + x * r, 0.5 + y * r, w) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
             for r, w in ((0.5, 0), (width / 2, 0), (width / 2 - 0.015625, 0.25), (top / 2, 1))]
    leather, stud = [], []
    for k, (outer, inner) in enumerate(zip(rings, rings[1:])):
        for i in range(4):
            j = (i + 1) % 4
            flat(stud if k else leather, outer[i], outer[j], inner[j], inner[i])
    flat(stud, *rings[-1])
    return {"leather": [s.in_cell(1.0) for s in leather], "stud": [s.in_cell(1.0) for s in stud]}


@tile("brick", "running bond: two courses of bricks with rounded edges, half a brick apart", 0.0625,
      {"mortar": ((0.50, 0.48, 0.44), 0.0, 0.9), "brick": ((0.42, 0.12, 0.06), 0.0, 0.8)}, covering=True,
      parameters={"joint": (0.125, 0.03125, 0.15625)})
def brick(joint=0.0625):
    """joint is the width of the mortar. The course above the lower joint has its bricks in the middle of the cell, the
    one above the upper joint has halves of two."""
    edge, g = 0.0390625, joint / 2
    mortar, bricks = [], []
    level = lambda *corners: flat(mortar, *[(u, v, 0) for u, v in corners])
    for v in (0.0, 0.5):  # bed joints, between the head joints of the course below and those of the course above
        below, above = ((0.5 - g, 0.5 + g), (g, 1 - g)) if v == 0 else ((g, 1 - g), (0.5 - g, 0.5 + g))
        down, up = [0, *below, 1], [0, *above, 1]
        for k in range(3):
            level((down[k], v), (down[k + 1], v), (up[k + 1], v + joint), (up[k], v + joint))
    level((0, joint), (g, joint), (g, 0.5), (0, 0.5))
    level((1 - g, joint), (1, joint), (1, 0.5), (1 - g, 0.5))
    level((0.5 - g, 0.5 + joint), (0.5 + g, 0.5 + joint), (0.5 + g, 1), (0.5 - g, 1))
    def block(u0, u1, v0, v1):  # a brick, or the part of it that lies in the cell
        a, b = (u0 + edge if u0 > 0 else u0), (u1 - edge if u1 < 1 else u1)
        outer, inner = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)], [(a, v0 + edge), (b, v0 + edge), (b, v1 - edge),
                                                                 (a, v1 - edge)]
        for i in range(4):
            j = (i + 1) % 4
            if outer[i] != inner[i] and outer[i][0] == outer[j][0] and outer[i][0] in (0, 1):
                continue  # it goes on in the next cell
            bricks.append(Surface([[outer[k] + (0,), outer[k] + (1,), inner[k] + (1,)] for k in (i, j)], (1, 2)))
        flat(bricks, *[p + (1,) for p in inner])
    block(g, 1 - g, joint, 0.5)
    block(0, 0.5 - g, 0.5 + joint, 1)
    block(0.5 + g, 1, 0.5 + joint, 1)
    return {"mortar": [s.in_cell(1.0) for s in mortar], "brick": [s.in_cell(1.0) for s in bricks]}


# ---- round things on a plate ----

def turned(u, v, profile):
    """Eight spans round (u, v), from the outer end of the profile, (radius, w), to the pole at its inner one."""
    rings = [[(u + x, v + y, w) for x, y in polygon(8, r)] for r, w in profile]
    return Surface(zip(*rings), cyclic=(True, False)).in_cell(1.0)


def plate(round_thing, u, v, half):
    """Eight patches from the square about (u, v) to the outer ring of what stands on it."""
    around = [round_thing.at(i, 0) for i in range(8)]
    w = around[0][2]
    outline = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    corner = [(u + half * x, v + half * y, w) for x, y in outline]
    patches = []
    for k in range(8):
        ring = [mid(around[k - 1], around[k]), around[k], mid(around[k], around[(k + 1) % 8])]
        a, b = corner[k], corner[(k + 1) % 8]
        patches.append(Surface(zip([a, mid(a, b), b], ring), (2, 1)))
    return patches


@tile("dimples", "a flat sheet with a round dimple in each cell", 0.1875, {"sheet": ((0.10, 0.22, 0.38), 0.0, 0.35)},
      covering=True, parameters={"depth": (0.25, 0.0, 1.0), "radius": (0.25, 0.125, 0.4375)})
def dimples(depth=1.0, radius=0.4375):
    """depth is that of the bowl, as part of the height; radius that of its rim."""
    bowl = turned(0.5, 0.5, [(radius, 1), (radius - 0.046875, 1), (0.64 * radius, 1 - depth), (0, 1 - depth)])
    return {"sheet": plate(bowl, 0.5, 0.5, 0.5) + [bowl]}


@tile("rivet", "a plate with a round-headed rivet in each cell", 0.25,
      {"plate": ((0.33, 0.34, 0.36), 1.0, 0.42), "rivet": ((0.62, 0.50, 0.34), 1.0, 0.25)}, covering=True,
      parameters={"radius": (0.125, 0.09375, 0.4375)})
def rivet(radius=0.28125):
    head = turned(0.5, 0.5, [(radius, 0), (radius, 0.5625), (0.625 * radius, 1), (0, 1)])
    return {"plate": plate(head, 0.5, 0.5, 0.5), "rivet": [head]}


def right_half(spline, move):
    """Spans -2 .. 1 round the axis, for move (0, 0, 0), or 2 .. 5, moved: the halves right and left of the axis."""
    first = -2 if move[0] == 0 else 2
    columns = []
    n = spline.sizes[1]
    point = lambda i, j: tuple(a + b for a, b in zip(spline.at(i, j), move))
    columns.append([mid(point(first - 1, j), point(first, j)) for j in range(n)])
    columns += [[point(i, j) for j in range(n)] for i in range(first, first + 4)]
    columns.append([mid(point(first + 3, j), point(first + 4, j)) for j in range(n)])
    return Surface(columns)


@tile("bubblewrap", "bubble wrap: a film with four round bubbles in each cell, in staggered rows", 0.1875,
      {"film": ((0.62, 0.74, 0.80), 0.0, 0.12)}, covering=True,
      parameters={"height": (0.25, 0.0625, 1.0), "radius": (0.125, 0.09375, 0.21875)})
def bubblewrap(height=1.0, radius=0.203125):
    """height is that of the bubbles, as part of the tile's; radius that of their foot."""
    profile = [(radius + 0.03125, 0), (radius, 0), (radius, height), (0, height)]
    film = []
    for u, v in ((0.25, 0.25), (0.75, 0.25), (0.5, 0.75)):
        bubble = turned(u, v, profile)
        film += plate(bubble, u, v, 0.25) + [bubble]
    bubble = turned(0, 0.75, profile)  # on the cell's border
    sheet = plate(bubble, 0, 0.75, 0.25)
    for k, s in enumerate(sheet):
        film.append(s if k in (0, 1, 6, 7) else s.map(lambda p: (p[0] + 1, p[1], p[2])))
    film += [right_half(bubble, (0, 0, 0)), right_half(bubble, (1, 0, 0))]
    return {"film": film}
