# SPDX-License-Identifier: Apache-2.0
"""Reliefs: one sheet each that covers the cell."""
from base import Surface, mid, tile

THORN_ASPECT = 0.75
# centre u, z, radius, slope of the ring's plane (z falls by it towards +u); the last is the tip
THORN = [(0.4375, 0, 0.4375, 0), (0.4375, 0, 0.23, 0), (0.46, 0.46, 0.15, 0.35), (0.84, 0.725, 0.03, 1.2),
         (0.84, 0.725, 0, 0)]


@tile("thorn", "a smooth sheet out of which one bent thorn grows, leaning towards +u", THORN_ASPECT,
      {"thorn": ((0.42, 0.28, 0.14), 0.0, 0.4)}, covering=True,
      parameters={"bend": (0.0, 0.0, 1.0), "height": (0.25, 0.125, 1.0), "radius": (0.5, 0.25, 1.0)})
def thorn(bend=1.0, height=1.0, radius=1.0):
    """bend goes from an upright horn to the bent one; height and radius scale the horn."""
    def ring(u, z, r, fall):
        r *= radius
        f = r / (1 + fall * fall) ** 0.5
        return [(u, 0.5 - r, z * height), (u + f, 0.5, (z - fall * f) * height), (u, 0.5 + r, z * height),
                (u - f, 0.5, (z + fall * f) * height)]
    rings = []
    for u, z, r, fall in THORN:
        upright = ring(THORN[0][0], z, r, 0)
        rings.append([tuple(a + bend * (b - a) for a, b in zip(p, x)) for p, x in zip(upright, ring(u, z, r, fall))])
    horn = Surface(zip(*rings), cyclic=(True, False)).in_cell(THORN_ASPECT)
    around = horn.clamped()
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    sheet = []
    for k in range(4):  # from the foot's span k out to side k of the cell
        ends = [around.at(0, 0)] + [mid(around.at(i, 0), around.at(i + 1, 0)) for i in (1, 2, 3)] + [around.at(5, 0)]
        foot = [ends[k], around.at(k + 1, 0), ends[k + 1]]
        a, b = corners[k] + (0.0,), corners[(k + 1) % 4] + (0.0,)
        sheet.append(Surface([[s, f] for s, f in zip([a, mid(a, b), b], foot)], (2, 1)))
    return {"thorn": [horn] + sheet}


@tile("knurl", "diamond knurling: pyramids with flattened crests between crossing V grooves", 0.1875,
      {"knurl": ((0.55, 0.56, 0.58), 1.0, 0.32)}, covering=True,
      parameters={"crest": (0.25, 0.03125, 0.375)})
def knurl(crest=0.0625):
    """Pyramids between two families of V grooves; crest is half the diagonal of their tops."""
    c = crest
    patches = []
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


@tile("bump", "one smooth dome in each cell", 0.25, {"bump": ((0.5, 0.05, 0.03), 0.0, 0.25)}, covering=True,
      parameters={"height": (0.0, 0.0, 1.0)})
def bump(height=1.0):
    """A dome height f(u) f(v), f the C1 quadratic spline with knots 0, 1/4, 3/4, 1 and f = 0 at the border, 1 inside."""
    f = [(0, 0.0), (0.125, 0), (0.25, 0.5), (0.5, 1.5), (0.75, 0.5), (0.875, 0), (1, 0)]
    patches = []
    for i in (0, 2, 4):
        for j in (0, 2, 4):
            patches.append(Surface([[(u, v, height * a * b) for v, b in f[j:j + 3]] for u, a in f[i:i + 3]]))
    return {"bump": [s.in_cell(1.0) for s in patches]}
