# SPDX-License-Identifier: Apache-2.0
"""What fills the height: lattices as volumes, a gyroid, and a sheet with holes."""
import itertools
import math

from base import Surface, Volume, add, tile
from grips import plate
from tubes import cross as times_cross, dot, polygon, sub, times, unit

STEEL = ((0.58, 0.59, 0.62), 1.0, 0.3)


def box(lo, hi):
    return Volume([[[(u, v, w) for w in (lo[2], hi[2])] for v in (lo[1], hi[1])] for u in (lo[0], hi[0])])


@tile("cross", "a lattice cell as volumes: struts along u, v and w that meet in a cube", 1.0, {"strut": STEEL},
      parameters={"width": (0.5, 0.0625, 0.75)})
def cross(width=0.25):
    """Seven boxes; struts end in the cell's border, at the base and at the top, where the next cells go on."""
    a, b = 0.5 - width / 2, 0.5 + width / 2
    parts = [box((a, a, a), (b, b, b))]
    for c in range(3):
        for lo, hi in ((0, a), (b, 1)):
            parts.append(box([lo if d == c else a for d in range(3)], [hi if d == c else b for d in range(3)]))
    return {"strut": [v.in_cell(1.0) for v in parts]}


# The edges of a rhombic dodecahedron, whose twelve faces look along the struts of the octet truss: with their sum 0
# it is four parallelepipeds about its centre, each spanned by three of them.
EDGES = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]


def parallelepiped(corner, a, b, c):
    if dot(a, times_cross(b, c)) < 0:
        b, c = c, b
    at = lambda i, j, k: add(corner, add(times(i, a), add(times(j, b), times(k, c))))
    return Volume([[[at(i, j, k) for k in (0, 1)] for j in (0, 1)] for i in (0, 1)])


OCTET_ASPECT = 1.25


@tile("octet", "the octet truss as volumes: struts along the diagonals of squares, nodes that fit between them",
      OCTET_ASPECT, {"node": ((0.75, 0.55, 0.25), 1.0, 0.3), "strut": STEEL},
      parameters={"radius": (0.0625, 0.015625, 0.0625)})
def octet(radius=0.046875):
    """Nodes are rhombic dodecahedra with edges (radius, radius, radius), at the lattice's points at the heights 0,
    1/2 and 1; a strut joins the faces of two nodes that look at each other. All of them are parallelepipeds."""
    nodes, struts = [], []
    edges = [times(radius, e) for e in EDGES]
    for level in range(3):
        for k in range(2):
            u = 0.5 * k
            center = (u, 0.5 - u if level == 1 else u, 0.5 * level)
            for i in range(4):
                nodes.append(parallelepiped(center, *[edges[j] for j in range(4) if j != i]))
            for i, j in itertools.permutations(range(4), 2):  # towards half the difference of two edges
                way = times(0.25, sub(EDGES[i], EDGES[j]))
                if way[2] < 0 or (level == 2 and way[2] > 0) or (way[2] == 0 and way[0] < 0):
                    continue  # another node's strut
                others = [edges[k] for k in range(4) if k not in (i, j)]
                struts.append(parallelepiped(add(center, edges[i]), *others, sub(way, sub(edges[i], edges[j]))))
    return {"node": [v.in_cell(OCTET_ASPECT, -0.125) for v in nodes],
            "strut": [v.in_cell(OCTET_ASPECT, -0.125) for v in struts]}


# ---- the gyroid: sin x cos y + sin y cos z + sin z cos x = 0 ----

def gyroid_value(p):
    s, c = [math.sin(x) for x in p], [math.cos(x) for x in p]
    value = s[0] * c[1] + s[1] * c[2] + s[2] * c[0]
    return value, (c[0] * c[1] - s[2] * s[0], c[1] * c[2] - s[0] * s[1], c[2] * c[0] - s[1] * s[2])


def onto_gyroid(p):
    for _ in range(30):
        value, g = gyroid_value(p)
        p = sub(p, times(value / dot(g, g), g))
    return p


def gyroid_quads():
    """The flat points, which lie on multiples of pi/2, are the corners of 24 skew quadrilaterals in a period, six
    about each: the corners of each, in units of pi/2, counterclockwise seen from where the function is positive."""
    flat = {k: gyroid_value(times(math.pi / 2, k))[1] for k in itertools.product(range(4), repeat=3)
            if abs(gyroid_value(times(math.pi / 2, k))[0]) < 1e-9}
    def around(k):  # the neighbours of k, diagonals of cubes that are not its normal, counterclockwise
        n = unit(flat[tuple(x % 4 for x in k)])
        found = [d for d in itertools.product((-1, 1), repeat=3)
                 if tuple(x % 4 for x in add(k, d)) in flat and abs(dot(d, n)) < 1.5]
        x = unit(sub(found[0], times(dot(found[0], n), n)))
        y = times_cross(n, x)
        return sorted(found, key=lambda d: math.atan2(dot(d, y), dot(d, x)))
    quads = {}
    for k in flat:
        ring = around(k)
        for a, b in zip(ring, ring[1:] + ring[:1]):
            p, r = add(k, a), add(k, b)
            ends = [{add(c, d) for d in around(c)} for c in (p, r)]
            opposite = [c for c in ends[0] & ends[1] if c != k]
            assert len(opposite) == 1, (k, a, b, opposite)
            quads.setdefault(tuple(sorted(tuple(x % 4 for x in c) for c in (k, p, r, opposite[0]))),
                             (k, p, opposite[0], r))
    return list(quads.values())


SPANS = 3


def quadratic(x):
    """The C1 quadratic basis over SPANS spans of length 1, clamped, at x."""
    k = min(int(x), SPANS - 1)
    t, out = x - k, [0.0] * (SPANS + 2)
    before, behind = (1.0 if k == 0 else 0.5), (1.0 if k == SPANS - 1 else 0.5)
    out[k], out[k + 2] = before * (1 - t) ** 2, behind * t * t
    out[k + 1] = 1 - out[k] - out[k + 2]
    return out


SITES = [0.0] + [k + 0.5 for k in range(SPANS)] + [float(SPANS)]


def interpolating(values):
    """Control points of the curve with these values at SITES: Gauss-Jordan, whose pivots are near the diagonal's."""
    rows = [quadratic(x) + [v] for x, v in zip(SITES, values)]
    for i in range(len(rows)):
        rows[i] = [x / rows[i][i] for x in rows[i]]
        rows = [r if j == i else [x - r[i] * y for x, y in zip(r, rows[i])] for j, r in enumerate(rows)]
    return [r[-1] for r in rows]


GYROID_ASPECT = 1.25
GYROID_ERROR = 2.5e-3  # of the cell: the farthest that samples of the patches are from the surface


def gyroid_patch(corners):
    """SPANS x SPANS biquadratic pieces, C1, through points of the gyroid beside the bilinear patch of the corners.
    Those on an edge depend on its ends alone."""
    a, b, c, d = [times(math.pi / 2, k) for k in corners]
    net = []
    for s in SITES:
        row = []
        for t in SITES:
            x, y = s / SPANS, t / SPANS
            row.append(onto_gyroid(add(add(times((1 - x) * (1 - y), a), times(x * (1 - y), b)),
                                       add(times(x * y, c), times((1 - x) * y, d)))))
        net.append(list(zip(*[interpolating(x) for x in zip(*row)])))
    columns = [list(zip(*[interpolating(x) for x in zip(*column)])) for column in zip(*net)]
    return [[times(0.5 / math.pi, p) for p in row] for row in zip(*columns)]


def patch_value(net, x, y):
    f, g = quadratic(x), quadratic(y)
    return tuple(sum(a * b * p[c] for a, row in zip(f, net) for b, p in zip(g, row)) for c in range(3))


@tile("gyroid", "a sheet like a gyroid, one period of it, that goes on in u and v", GYROID_ASPECT,
      {"sheet": ((0.05, 0.30, 0.42), 0.0, 0.3)})
def gyroid():
    """24 patches of SPANS x SPANS pieces. What fitting leaves is checked here: GYROID_ERROR."""
    patches, worst = [], 0.0
    for corners in gyroid_quads():
        middle = [sum(k[c] for k in corners) / 4 for c in range(3)]
        corners = [sub(k, tuple(4 * math.floor(m / 4) for m in middle)) for k in corners]
        net = gyroid_patch(corners)
        for i in range(6 * SPANS + 1):
            for j in range(6 * SPANS + 1):
                value, g = gyroid_value(times(2 * math.pi, patch_value(net, i / 6, j / 6)))
                worst = max(worst, abs(value) / math.sqrt(dot(g, g)) / (2 * math.pi))
        patches.append(Surface(net).in_cell(GYROID_ASPECT, -0.25))
    assert worst <= GYROID_ERROR, worst
    return {"sheet": patches}


@tile("frame", "a sheet of some thickness with a round window in each cell, the same from above and below", 0.125,
      {"frame": ((0.72, 0.16, 0.06), 0.0, 0.35)}, parameters={"window": (0.125, 0.0625, 0.40625)})
def frame(window=0.3125):
    """window is the radius of the hole. Top and bottom go on in the next cells; w = 1/2 is the middle, about which
    the tile is its own mirror image: a strip of it may be closed with half a twist."""
    ring = lambda r, w: [(0.5 + x, 0.5 + y, w) for x, y in polygon(8, r)]
    rim = window + 0.0625
    wall = Surface(zip(*[ring(r, w) for r, w in ((rim, 1), (window, 1), (window, 0), (rim, 0))]),
                   cyclic=(True, False)).in_cell(1.0)
    top = plate(wall, 0.5, 0.5, 0.5)
    bottom = [s.map(lambda p: (p[0], p[1], 1 - p[2])).reversed() for s in top]
    return {"frame": [wall] + top + bottom}
