# SPDX-License-Identifier: Apache-2.0
"""Scales: two rows a cell, staggered; one folded sheet."""
from base import Surface, tile

ASPECT = 0.3125
# Slopes over the aspect, and lengths, are short binary fractions: the joints of a top stay C1 exactly.
SHAPE = dict(shoulder=0.53125, tip=0.953125, point=0.35, nose=0.03125,
             mid=0.155, slope=0.15625, dome=0.03, ridge=0.05, hollow=0.02)


def half_scale(s):
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


@tile("scale", "overlapping scales with a ridge, two staggered rows in each cell, tips towards +v", ASPECT,
      {"scale": ((0.04, 0.27, 0.19), 0.25, 0.28)}, covering=True,
      parameters={"lift": (0.15625, 0.15625, 0.46875), "thickness": (0.025, 0.025, 0.05)})
def scale(lift=0.46875, thickness=0.05):
    """lift is the slope of the tips, thickness that of the edge below them, in widths of a cell."""
    patches = []
    for k, net in enumerate(half_scale(dict(SHAPE, lift=lift, thick=thickness))):
        for side in (1, -1):
            half = Surface(net)
            a = half.map(lambda p: (0.5 + side * p[0] / 2, p[1], p[2]))
            shift = 0.5 if k == 0 else -0.5
            b = half.map(lambda p: ((0 if side > 0 else 1) + side * p[0] / 2, p[1] + shift, p[2]))
            for s in (a, b):
                patches.append(s if side > 0 else s.reversed(0))
    return {"scale": [s.in_cell(ASPECT) for s in patches]}
