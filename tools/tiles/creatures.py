# SPDX-License-Identifier: Apache-2.0
"""A flower that was a thorn, a bird that becomes a fish, an ant."""
from base import Surface, mid, square, tile
from relief import THORN, THORN_ASPECT
from tubes import polygon, rings

# ---- flower: the thorn's surfaces, knots and foot ----

# As THORN: centre u, z, radius, how much the lip falls towards +u.
BLOOM = [(0.4375, 0, 0.4375, 0), (0.4375, 0, 0.14, 0), (0.5, 0.52, 0.02, 0), (0.5, 0.86, 0.66, 0.05),
         (0.5, 0.59, 0, 0)]


@tile("flower", "a trumpet blossom on a slender stem that grows out of a smooth sheet, made as the thorn is",
      THORN_ASPECT, {"flower": ((0.62, 0.10, 0.22), 0.0, 0.35)}, covering=True, parameters={"bloom": (0.0, 0.0, 1.0)})
def flower(bloom=1.0):
    """bloom leads from the thorn, 0, to the blossom, 1: both are closed rings about a stem, the last one a point."""
    blend = lambda a, b: (1 - bloom) * a + bloom * b
    net = []
    for t, f in zip(THORN, BLOOM):
        rows = []
        for u, z, radius, fall in (t, f):
            x = radius / (1 + fall * fall) ** 0.5
            rows.append([(u, 0.5 - radius, z), (u + x, 0.5, z - fall * x), (u, 0.5 + radius, z),
                         (u - x, 0.5, z + fall * x)])
        net.append([tuple(blend(x, y) for x, y in zip(a, b)) for a, b in zip(*rows)])
    horn = Surface(zip(*net), cyclic=(True, False)).in_cell(THORN_ASPECT)
    around = horn.clamped()
    corners = [(0, 0), (1, 0), (1, 1), (0, 1)]
    sheet = []
    for k in range(4):
        ends = [around.at(0, 0)] + [mid(around.at(i, 0), around.at(i + 1, 0)) for i in (1, 2, 3)] + [around.at(5, 0)]
        foot = [ends[k], around.at(k + 1, 0), ends[k + 1]]
        a, b = corners[k] + (0.0,), corners[(k + 1) % 4] + (0.0,)
        sheet.append(Surface([[s, f] for s, f in zip([a, mid(a, b), b], foot)], (2, 1)))
    return {"flower": [horn] + sheet}


# ---- bird and fish: reliefs with one outline each, point for point ----

RELIEF_ASPECT = 0.125
# From the beak or mouth, left, over the back to the tail, right, and back along the belly: 24 points. The spine below
# is where the two halves of the back meet; it is run to and fro, and its first and last three points are one.
BIRD = [(0.02, 0.475), (0.06, 0.502), (0.125, 0.555), (0.19, 0.522), (0.30, 0.515), (0.38, 0.60), (0.46, 0.985),
        (0.68, 0.985), (0.55, 0.67), (0.68, 0.545), (0.82, 0.512), (0.975, 0.575), (0.895, 0.475), (0.975, 0.375),
        (0.82, 0.438), (0.68, 0.405), (0.55, 0.28), (0.68, 0.015), (0.46, 0.015), (0.38, 0.35), (0.30, 0.435),
        (0.19, 0.428), (0.125, 0.395), (0.06, 0.448)]
FISH = [(0.04, 0.48), (0.07, 0.545), (0.14, 0.62), (0.23, 0.685), (0.32, 0.72), (0.39, 0.80), (0.47, 0.895),
        (0.60, 0.845), (0.59, 0.66), (0.70, 0.585), (0.82, 0.545), (0.965, 0.73), (0.885, 0.49), (0.955, 0.26),
        (0.81, 0.43), (0.70, 0.385), (0.61, 0.305), (0.56, 0.20), (0.48, 0.235), (0.41, 0.265), (0.31, 0.27),
        (0.22, 0.305), (0.13, 0.37), (0.07, 0.43)]
BIRD_SPINE = [(0.13, 0.475), (0.16, 0.48), (0.24, 0.48), (0.32, 0.48), (0.40, 0.49), (0.47, 0.50), (0.52, 0.50),
              (0.56, 0.49), (0.62, 0.485), (0.74, 0.475), (0.84, 0.47)]
FISH_SPINE = [(0.13, 0.49), (0.16, 0.495), (0.23, 0.50), (0.32, 0.505), (0.40, 0.505), (0.48, 0.505), (0.54, 0.50),
              (0.60, 0.495), (0.68, 0.49), (0.76, 0.49), (0.84, 0.49)]


def relief(outline, spine, crest):
    """A closed solid between the base and a rounded back: rings from the spine at the base out to the outline and
    back to the spine, at the height `crest` of each of its points."""
    n = len(outline)
    there = [spine[0]] + spine + [spine[-1]]  # points 0 and 1 are one, and so are the last two
    heights = [crest[0]] + crest + [crest[-1]]
    ring = there[:n // 2 + 1] + there[n // 2 - 1:0:-1]
    high = heights[:n // 2 + 1] + heights[n // 2 - 1:0:-1]
    between = lambda k, a: tuple(a * x + (1 - a) * y for x, y in zip(outline[k], ring[k]))
    net = []
    for k in range(n):
        net.append([ring[k] + (0,), outline[k] + (0,), outline[k] + (0.45,), between(k, 0.55) + (high[k],),
                    ring[k] + (high[k],)])
    return [Surface(net, cyclic=(True, False)).in_cell(1.0).reversed()]


BIRD_CREST = [0.85, 0.9, 0.9, 0.85, 0.9, 1, 1, 1, 0.9, 0.8, 0.7]
FISH_CREST = [0.75, 0.85, 0.95, 1, 1, 1, 1, 0.95, 0.85, 0.75, 0.65]
FEATHER, SKIN = ((0.30, 0.36, 0.42), 0.0, 0.45), ((0.80, 0.36, 0.08), 0.1, 0.3)


def between(change):
    blend = lambda a, b: [tuple((1 - change) * x + change * y for x, y in zip(p, r)) for p, r in zip(a, b)]
    crest = [(1 - change) * x + change * y for x, y in zip(BIRD_CREST, FISH_CREST)]
    return relief(blend(BIRD, FISH), blend(BIRD_SPINE, FISH_SPINE), crest)


@tile("bird", "a flying bird in relief, compatible with the fish", RELIEF_ASPECT, {"bird": FEATHER})
def bird():
    return {"bird": between(0.0)}


@tile("fish", "a fish in relief, compatible with the bird", RELIEF_ASPECT, {"fish": SKIN})
def fish():
    return {"fish": between(1.0)}


@tile("birdfish", "a bird that becomes a fish", RELIEF_ASPECT, {"body": ((0.46, 0.42, 0.34), 0.0, 0.4)},
      parameters={"change": (1.0, 0.0, 1.0)})
def birdfish(change=0.0):
    """change leads from the bird, 0, to the fish, 1."""
    return {"body": between(change)}


# ---- ant ----

ANT_ASPECT = 0.375


def blob(path):
    """A closed body along u: (u, z, half width, half height) of its rings, the first and the last one a point."""
    net = [[(u, 0.5 + x * a, z - y * b) for x, y in polygon(6, 1.0)] for u, z, a, b in path]
    return Surface(net, cyclic=(False, True)).in_cell(ANT_ASPECT)


def limb(path, radii):
    """A closed tube whose ends are points."""
    before = tuple(2 * a - b for a, b in zip(path[0], path[1]))
    behind = tuple(2 * a - b for a, b in zip(path[-1], path[-2]))
    tips = rings(path, lambda i: square(radii[i]), before, behind)
    net = [[path[0]] * 4] + tips + [[path[-1]] * 4]
    return Surface(net, cyclic=(False, True)).in_cell(ANT_ASPECT)


@tile("ant", "an ant on its six feet, its head towards +u", ANT_ASPECT,
      {"body": ((0.035, 0.022, 0.015), 0.0, 0.25), "leg": ((0.09, 0.05, 0.03), 0.0, 0.35)})
def ant():
    """Head, thorax and abdomen, six legs whose feet touch the base, two feelers: closed bodies, which reach into each
    other where they meet."""
    body = [blob([(0.06, 0.15, 0, 0), (0.06, 0.15, 0.085, 0.07), (0.21, 0.185, 0.135, 0.125),
                  (0.37, 0.16, 0.10, 0.095), (0.42, 0.13, 0.022, 0.022), (0.42, 0.13, 0, 0)]),
            blob([(0.40, 0.13, 0, 0), (0.40, 0.13, 0.022, 0.022), (0.45, 0.145, 0.06, 0.06),
                  (0.57, 0.165, 0.07, 0.068), (0.65, 0.165, 0.028, 0.028), (0.65, 0.165, 0, 0)]),
            blob([(0.63, 0.165, 0, 0), (0.63, 0.165, 0.045, 0.04), (0.69, 0.185, 0.105, 0.085),
                  (0.78, 0.165, 0.085, 0.07), (0.845, 0.13, 0.035, 0.03), (0.845, 0.13, 0, 0)])]
    legs = []
    for hip, knee, shin, foot in (((0.46, 0.04), (0.38, 0.17), (0.31, 0.31), (0.24, 0.37)),
                                  ((0.52, 0.05), (0.52, 0.19), (0.52, 0.34), (0.51, 0.43)),
                                  ((0.58, 0.04), (0.65, 0.17), (0.71, 0.31), (0.78, 0.38))):
        for side in (1, -1):
            at = lambda p, z: (p[0], 0.5 + side * p[1], z)
            legs.append(limb([at(hip, 0.14), at(knee, 0.32), at(shin, 0.12), at(foot, 0.012)],
                             [0.02, 0.018, 0.012, 0.012]))
    for side in (1, -1):
        legs.append(limb([(0.80, 0.5 + side * 0.035, 0.17), (0.86, 0.5 + side * 0.10, 0.30),
                          (0.965, 0.5 + side * 0.15, 0.25)], [0.011, 0.009, 0.007]))
    return {"body": body, "leg": legs}
