# SPDX-License-Identifier: Apache-2.0
"""Wicker, basket weave, knitting and rope: strands that pass over and under each other."""
import math

from base import Surface, mid, q, tile
from tubes import in_cell, piece, polygon, rings, strand

CANE = ((0.55, 0.33, 0.13), 0.0, 0.45)
DARK_CANE = ((0.30, 0.15, 0.055), 0.0, 0.45)


def wave(v, phase, rise):
    """A strand along u that is highest at u = 1/4, if phase is 1, and lowest at 3/4: its control points are twice as
    high. All rings are upright, those on the cell's border too."""
    return [(0.25, v, 2 * phase * rise), (0.75, v, -2 * phase * rise)]


def woven(v, phase, rise, section):
    return strand(wave(v, phase, rise), section, (1, 0, 0), mitre=0.5)


def along_v(spline):
    """Mirrored at the diagonal: a strand along u becomes one along v, still facing outwards."""
    turned = spline.map(lambda p: (p[1], p[0], p[2])).reversed()
    turned.cyclic = tuple(c if isinstance(c, bool) else (c[1], c[0], c[2]) for c in turned.cyclic)
    return turned


WICKER_RISE = 0.1171875
WICKER_ASPECT = 0.4609375


@tile("wicker1", "plain wicker: round canes of equal thickness, over one and under one both ways", WICKER_ASPECT,
      {"weft": CANE, "warp": ((0.45, 0.25, 0.09), 0.0, 0.45)}, parameters={"thickness": (0.0625, 0.05, 0.09375)})
def wicker1(thickness=0.09375):
    """Two strands each way; thickness is their radius."""
    section = polygon(4, thickness)
    weft = [woven(v, phase, WICKER_RISE, section) for v, phase in ((0.25, 1), (0.75, -1))]
    warp = [along_v(s) for s in (woven(v, phase, WICKER_RISE, section)
                                 for v, phase in ((0.25, -1), (0.75, 1)))]
    cell = lambda strands: [s.in_cell(WICKER_ASPECT, -WICKER_ASPECT / 2) for s in strands]
    return {"weft": cell(weft), "warp": cell(warp)}


STAKE = 0.0546875
STAKED_RISE = 0.1484375
STAKED_ASPECT = 0.46875


@tile("wicker2", "staked wicker: canes woven closely round straight stakes along v", STAKED_ASPECT,
      {"cane": CANE, "stake": DARK_CANE}, parameters={"thickness": (0.03125, 0.03, 0.06640625)})
def wicker2(thickness=0.06640625):
    """Six canes along u, two straight stakes along v; thickness is the radius of a cane."""
    canes = [woven((k + 0.5) / 6, 1 if k % 2 == 0 else -1, STAKED_RISE, polygon(4, thickness))
             for k in range(6)]
    stakes = [Surface([[(u + x, v, y) for x, y in polygon(4, STAKE)] for v in (0, 1)], (1, 2), (False, True))
              for u in (0.25, 0.75)]
    cell = lambda strands: [s.in_cell(STAKED_ASPECT, -STAKED_ASPECT / 2) for s in strands]
    return {"cane": cell(canes), "stake": cell(stakes)}


def strap(width, thickness):
    """Half as wide and thick as said on each side: nearly flat, thin towards its edges."""
    w = 0.8 * width
    return [(width, 0), (w, thickness), (-w, thickness), (-width, 0), (-w, -thickness), (w, -thickness)]


BASKET_ASPECT = 0.24609375


@tile("basket", "basket weave: flat straps, over one and under one both ways", BASKET_ASPECT,
      {"weft": ((0.62, 0.44, 0.22), 0.0, 0.5), "warp": ((0.36, 0.2, 0.08), 0.0, 0.5)},
      parameters={"width": (0.125, 0.1, 0.2265625)})
def basket(width=0.2265625):
    """Two straps each way; width is half of theirs."""
    rise, section = 0.0859375, strap(width, 0.03125)
    weft = [woven(v, phase, rise, section) for v, phase in ((0.25, 1), (0.75, -1))]
    warp = [along_v(woven(v, -phase, rise, section)) for v, phase in ((0.25, 1), (0.75, -1))]
    cell = lambda strands: [s.in_cell(BASKET_ASPECT, -BASKET_ASPECT / 2) for s in strands]
    return {"weft": cell(weft), "warp": cell(warp)}


KNIT_ASPECT = 0.578125
KNIT_LEAN, KNIT_DEPTH = 1.6, 0.19
KNIT_AT = [0.26, 0.72, 1.1, 1.4]  # of a quarter of the stitch: the second and third lie about the cell's border


@tile("knit", "stockinette knitting: a stitch in each cell, hung into those of the rows before and behind", KNIT_ASPECT,
      {"yarn": ((0.45, 0.04, 0.05), 0.0, 0.75)}, parameters={"thickness": (0.0625, 0.05, 0.10546875)})
def knit(thickness=0.10546875):
    """The stitch u = t + 1.6 sin 2t, v = cos t, z = -cos 2t, from the middle of its head (t = 0) to that of its foot,
    where the next begins, and mirrored. It reaches beyond its row: head and feet are moved by a cell. thickness is the
    radius of the yarn."""
    at = KNIT_AT + [math.pi - t for t in reversed(KNIT_AT)]
    height = 1 / (math.cos(at[1]) + math.cos(at[2]))
    path = [(0.5 + (t + KNIT_LEAN * math.sin(2 * t)) / (2 * math.pi), 0.5 + height * math.cos(t),
             -KNIT_DEPTH * math.cos(2 * t)) for t in at]
    mirror = lambda p, u: (2 * u - p[0], p[1], p[2])
    level = {i: (0, 1, 0) for i in (1, 2, 5, 6)}
    half = rings(path, polygon(4, thickness), mirror(path[0], 0.5), mirror(path[-1], 1.0),
                 planes={i: (0, 1, 0) for i in (1, 2, 5, 6)})
    half = in_cell(half, KNIT_ASPECT, -KNIT_ASPECT / 2)
    for i, v in ((1, 1.0), (5, 0.0)):  # the cell's border lies midway between two rings
        half[i] = [(p[0], 2 * v - o[1], p[2]) for p, o in zip(half[i], half[i + 1])]
    other = [[mirror(p, 0.5) for p in ring] for ring in half[::-1]]
    whole = other + half  # from foot to foot; and the rings next to it
    whole = [[mirror(p, 0.0) for p in whole[0]]] + whole + [[mirror(p, 1.0) for p in whole[-1]]]
    head, foot = (0, -1, 0), (0, 1, 0)
    return {"yarn": [piece(whole, 1, 2, foot), piece(whole, 3, 6), piece(whole, 7, 10, head), piece(whole, 11, 14),
                     piece(whole, 15, 16, foot)]}


ROPE_STRAND, ROPE_LAY = 0.1796875, 0.21875  # radius of a strand, and of the helix of its middle
ROPE_ASPECT = 0.828125


@tile("rope", "a rope of three strands along u, a third of a turn in each cell", ROPE_ASPECT,
      {"strand": ((0.50, 0.36, 0.18), 0.0, 0.8)}, parameters={"thickness": (0.125, 0.0625, 0.1796875)})
def rope(thickness=ROPE_STRAND, steps=4):
    """thickness is the radius of a strand. Each strand goes on as the next one."""
    lay = ROPE_LAY / math.cos(math.pi / 3 / steps)  # of the control polygon
    def at(k, turn):
        a = 2 * math.pi / 3 * ((k + 0.5) / steps + turn)
        return ((k + 0.5) / steps, 0.5 + lay * math.cos(a), lay * math.sin(a))
    strands = []
    for turn in range(3):
        path = [at(k, turn) for k in range(steps)]
        net = [rings([at(k, turn)], polygon(6, thickness), at(k - 1, turn), at(k + 1, turn),
                     planes={0: (1, 0, 0)}, up=(0, math.cos(2 * math.pi / 3 * ((k + 0.5) / steps + turn)),
                         math.sin(2 * math.pi / 3 * ((k + 0.5) / steps + turn))))[0] for k in range(steps)]
        strands.append(in_cell(net, ROPE_ASPECT, -ROPE_ASPECT / 2))
    whole = lambda ring, u: [(p[0] + u, p[1], p[2]) for p in ring]
    # the strand before this one ends where it begins
    return {"strand": [piece([whole(strands[(k - 1) % 3][-1], -1)] + strands[k] + [whole(strands[(k + 1) % 3][0], 1)],
                             1, steps) for k in range(3)]}
