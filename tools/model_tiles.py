#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the geometry of the built-in tiles: python3 tools/model_tiles.py data/tiles

Every tile is modelled in real proportions, cell width 1, and written in cell coordinates (u, v, w), w = z / aspect.
Control points are multiples of 2^-12 (midpoints of them where a closed surface is clamped) and knots are integers, so
that splitting at knots, mirroring and translating by whole cells are exact in binary, and edges that belong together
are equal bit for bit.
"""
import os
import sys

GRID = 4096


def q(x):
    """The nearest multiple of 2^-12."""
    return round(x * GRID) / GRID


def mid(a, b):
    return tuple((x + y) / 2 for x, y in zip(a, b))


def clamped(degree, spans):
    return [0] * (degree + 1) + list(range(1, spans)) + [spans] * (degree + 1)


def closed(points):
    """Clamped control points of the closed C1 quadratic with these control points, one span for each; it starts
    midway between the last and the first."""
    seam = mid(points[-1], points[0])
    return [seam] + points + [seam]


class Surface:
    """net[i][j]: the control point for r = i, t = j; degree 2 or 1 in each variable, C1 over integer knots; closed in
    r or t: the net is cyclic there."""

    def __init__(self, net, degree=(2, 2), cyclic=(False, False)):
        self.net = [[tuple(p) for p in row] for row in net]
        self.degree = degree
        self.cyclic = cyclic

    def reversed(self):
        return Surface([row[::-1] for row in self.net], self.degree, self.cyclic)

    def map(self, f):
        return Surface([[f(p) for p in row] for row in self.net], self.degree, self.cyclic)

    def in_cell(self, aspect, z0=0.0):
        return self.map(lambda p: (q(p[0]), q(p[1]), q((p[2] - z0) / aspect)))

    def clamped(self):
        net = [closed(row) if self.cyclic[1] else row for row in self.net]
        if self.cyclic[0]:
            net = [list(row) for row in zip(*[closed(list(column)) for column in zip(*net)])]
        return net

    def g2(self):
        net = self.clamped()
        lines = ["200 1 0 0", "3 0"]
        for d, n in ((self.degree[0], len(net)), (self.degree[1], len(net[0]))):
            lines += ["%d %d" % (n, d + 1), " ".join(map(str, clamped(d, n - d)))]
        for j in range(len(net[0])):
            for row in net:
                lines.append(" ".join(repr(float(c)).removesuffix(".0") for c in row[j]))
        return "\n".join(lines) + "\n"


# ---- chain: Japanese four-in-one mail: flat rings joined by upright links ----

CHAIN = dict(ring=0.3984375, wire=0.078125, link=(0.296875, 0.1875), link_wire=0.0625)
CHAIN_ASPECT = 0.5  # twice the link's half height, wire included


def square(a):
    """A control square whose closed quadratic is nearly a circle of radius a, the seam at (a, 0)."""
    return [(a, a), (-a, a), (-a, -a), (a, -a)]


def chain_ring():
    return Surface([[(0.5 + x * (CHAIN["ring"] + e), 0.5 + y * (CHAIN["ring"] + e), z)
                     for e, z in square(CHAIN["wire"])] for x, y in square(1.0)], cyclic=(True, True))


def chain_half_link():
    """The half at u <= 1 of the link about (1, .5), from the top of the plane u = 1 to its bottom."""
    half, height = CHAIN["link"]
    path = [(0, 1), (-1, 1), (-1, -1), (0, -1)]
    return Surface([[(1 + x * (half + e), 0.5 + y, z * (height + e)) for e, y in square(CHAIN["link_wire"])]
                    for x, z in path], cyclic=(False, True)).reversed()


def chain():
    z0 = -CHAIN_ASPECT / 2
    right = chain_half_link()
    left = right.map(lambda p: (1 - p[0], p[1], p[2])).reversed()
    turn = lambda p: (p[1], p[0], p[2])
    links = [right, left, right.map(turn).reversed(), left.map(turn).reversed()]
    return {"ring": [chain_ring().in_cell(CHAIN_ASPECT, z0)], "link": [s.in_cell(CHAIN_ASPECT, z0) for s in links]}


# ---- scale: two rows of scales a cell, staggered; one folded sheet ----

SCALE_ASPECT = 0.3125
# Slopes over the aspect, and lengths, are short binary fractions: the joints of a top stay C1 exactly.
SCALE = dict(shoulder=0.53125, tip=0.953125, point=0.35, nose=0.03125, thick=0.05,
             mid=0.155, slope=0.15625, lift=0.46875, dome=0.03, ridge=0.05, hollow=0.02)


def scale_half(s):
    """Half a scale in its own coordinates: x from 0 at the ridge to 1 at the shoulder (half a cell), y from its root
    at 0; z. Nets over x (three columns) by t (three rows): lower and upper top, nose, underside."""
    def column(a, b, c):  # quadratic Bernstein coefficients of a + b x + c x^2
        return (a, a + b / 2, a + b + c)
    drop = s["tip"] - s["shoulder"]
    rim = [round(y * 512) / 512 for y in column(s["tip"], -drop * s["point"], -drop * (1 - s["point"]))]
    middle = column(s["mid"], -s["ridge"], -s["dome"])
    lower, upper, nose, under = [], [], [], []
    for i in range(3):
        x, half = i / 2, (rim[i] - 0.5) / 2
        lower.append([(x, 0, 0), (x, 0.25, middle[i] - s["slope"] * 0.25), (x, 0.5, middle[i])])
        turn = (x, 0.5 + half, middle[i] + s["slope"] * half)
        edge = (x, rim[i], turn[2] + s["lift"] * half)
        upper.append([lower[i][2], turn, edge])
        below = (x, rim[i], edge[2] - s["thick"])
        nose.append([edge, (x, rim[i] + s["nose"], edge[2] + s["nose"] * s["lift"]), below])
        under.append([below, (x, 0.5 + s["hollow"], turn[2] - s["thick"]), (x, 0.5, 0)])
    return [lower, upper, nose, under]


def scale():
    half = scale_half(SCALE)
    patches = []
    for k, net in enumerate(half):
        for side in (1, -1):
            a = Surface(net).map(lambda p: (0.5 + side * p[0] / 2, p[1], p[2]))
            shift = 0.5 if k == 0 else -0.5
            b = Surface(net).map(lambda p: ((0 if side > 0 else 1) + side * p[0] / 2, p[1] + shift, p[2]))
            for s in (a, b):
                patches.append(s if side > 0 else Surface(s.net[::-1]))
    return {"scale": [s.in_cell(SCALE_ASPECT) for s in patches]}


# ---- thorn: a flat sheet out of which a bent horn grows ----

THORN_ASPECT = 0.75
# centre u, z, radius, slope of the ring's plane (z falls by it towards +u); the last is the tip
THORN = [(0.4375, 0, 0.4375, 0), (0.4375, 0, 0.23, 0), (0.46, 0.46, 0.15, 0.35), (0.84, 0.725, 0.03, 1.2), (0.84, 0.725, 0, 0)]


def thorn():
    rings = []
    for u, z, radius, fall in THORN:
        f = radius / (1 + fall * fall) ** 0.5
        rings.append([(u, 0.5 - radius, z), (u + f, 0.5, z - fall * f), (u, 0.5 + radius, z), (u - f, 0.5, z + fall * f)])
    horn = Surface(zip(*rings), cyclic=(True, False)).in_cell(THORN_ASPECT)
    around = horn.clamped()
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    sheet = []
    for k in range(4):  # from the foot's span k out to side k of the cell
        ends = [around[0][0]] + [mid(around[i][0], around[i + 1][0]) for i in (1, 2, 3)] + [around[5][0]]
        foot = [ends[k], around[k + 1][0], ends[k + 1]]
        a, b = corners[k] + (0.0,), corners[(k + 1) % 4] + (0.0,)
        side = [a, mid(a, b), b]
        sheet.append(Surface([[s, f] for s, f in zip(side, foot)], (2, 1)))
    return {"thorn": [horn] + sheet}


# ---- knurl: pyramids between two families of V grooves ----

KNURL_ASPECT = 0.1875
KNURL_CREST = 0.0625


def knurl():
    c = KNURL_CREST
    flat, patches = [], []
    def patch(p00, p10, p01, p11):
        patches.append(Surface([[p00, p01], [p10, p11]], (1, 1)))
    turn = lambda p: (1 - p[1], p[0], p[2])  # a quarter turn about the cell's centre
    inner = [(0.5, 0, 0), (1, 0.5, 0), (0.5, 0.5 - c, 1), (0.5 + c, 0.5, 1)]
    corner = [(0.5, 0, 0), (0, 0.5, 0), (c, 0, 1), (0, c, 1)]
    cap = [(0, 0, 1), (c, 0, 1), (0, 0, 1), (0, c, 1)]
    for _ in range(4):
        patch(*inner)
        patch(*corner)
        patch(*cap)
        inner, corner, cap = [[turn(p) for p in f] for f in (inner, corner, cap)]
    patch((0.5, 0.5 - c, 1), (0.5 + c, 0.5, 1), (0.5 - c, 0.5, 1), (0.5, 0.5 + c, 1))
    return {"knurl": [s.in_cell(1.0) for s in patches]}


# ---- bump: a dome f(u) f(v), f the C1 quadratic spline with knots 0, 1/4, 3/4, 1 and f = 0 at the border, 1 inside ----

BUMP_ASPECT = 0.25


def bump():
    f = [(0, 0.0), (0.125, 0), (0.25, 0.5), (0.5, 1.5), (0.75, 0.5), (0.875, 0), (1, 0)]
    patches = []
    for i in (0, 2, 4):
        for j in (0, 2, 4):
            patches.append(Surface([[(u, v, a * b) for v, b in f[j:j + 3]] for u, a in f[i:i + 3]]))
    return {"bump": [s.in_cell(1.0) for s in patches]}


def main(folder):
    for name, tile in (("chain", chain()), ("scale", scale()), ("thorn", thorn()), ("knurl", knurl()), ("bump", bump())):
        os.makedirs(os.path.join(folder, name), exist_ok=True)
        for part, surfaces in tile.items():
            with open(os.path.join(folder, name, part + ".g2"), "w", encoding="ascii") as out:
                out.write("".join(s.g2() for s in surfaces))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: model_tiles.py FOLDER")
    main(sys.argv[1])
