#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the bases and the tiles' parts of the gallery: python3 tools/model_bases.py data examples/gallery

Surfaces of revolution are polynomial: u runs around the z axis in eight cubic spans (C1, radius true to 4e-6), v up a
clamped uniform cubic B-spline (C2) with the control points (r, z) below. A last pair at r = 0 is a smooth pole.
"""
import math
import os
import sys

SPANS = 8

# (r, z) from the foot up
PAWN = [(1.10, 0), (1.18, 0.12), (1.18, 0.36), (0.92, 0.52), (0.74, 0.72), (0.56, 1.2), (0.47, 1.75),
        (0.44, 2.1), (0.84, 2.22), (0.84, 2.42), (0.40, 2.5), (0.56, 2.6), (0.94, 2.86), (1.0, 3.3),
        (0.86, 3.72), (0.46, 3.98), (0, 3.98)]
BISHOP = [(1.14, 0), (1.22, 0.12), (1.22, 0.38), (0.95, 0.55), (0.76, 0.8), (0.55, 1.5), (0.45, 2.2),
          (0.42, 2.7), (0.86, 2.84), (0.86, 3.04), (0.42, 3.16), (0.6, 3.45), (0.86, 3.95), (0.66, 4.6),
          (0.3, 5.05), (0.26, 5.2), (0.3, 5.36), (0.14, 5.5), (0, 5.5)]
GLASS = [(1.05, 0.02), (1.1, 0.1), (0.7, 0.18), (0.22, 0.32), (0.16, 0.8), (0.16, 1.35), (0.36, 1.62),
         (0.92, 1.95), (1.2, 2.6), (1.16, 3.3), (1.0, 3.9)]
VASE = [(0.75, 0), (0.95, 0.1), (1.35, 0.7), (1.5, 1.4), (1.2, 2.2), (0.72, 2.8), (0.6, 3.2), (0.72, 3.6),
        (0.95, 3.85)]
BOTTLE = [(0.9, 0), (1.08, 0.1), (1.15, 0.8), (1.1, 1.7), (0.8, 2.3), (0.42, 2.7), (0.36, 3.3), (0.38, 3.8),
          (0.52, 4.0)]


def circle():
    """Control points of the unit circle, closed, and its knots."""
    angle = 2 * math.pi / SPANS
    k = 4 / 3 * math.tan(angle / 4)
    points = [(1.0, 0.0)]
    for i in range(SPANS):
        a, b = i * angle, (i + 1) * angle
        points.append((math.cos(a) - k * math.sin(a), math.sin(a) + k * math.cos(a)))
        points.append((math.cos(b) + k * math.sin(b), math.sin(b) - k * math.cos(b)))
    points.append((1.0, 0.0))
    knots = [0] * 4 + [i for i in range(1, SPANS) for _ in range(2)] + [SPANS] * 4
    return points, knots


def revolved(profile, at=(0.0, 0.0, 0.0), scale=1.0):
    around, knots_u = circle()
    n = len(profile)
    knots_v = [0] * 4 + list(range(1, n - 3)) + [n - 3] * 4
    lines = ["200 1 0 0", "3 0", "%d 4" % len(around), " ".join(map(str, knots_u)), "%d 4" % n,
             " ".join(map(str, knots_v))]
    for r, z in profile:
        for x, y in around:
            lines.append("%.17g %.17g %.17g" % (at[0] + scale * r * x, at[1] + scale * r * y, at[2] + scale * z))
    return "\n".join(lines) + "\n"


def bezier_patches(path):
    """The patches of a .bpt file as .g2 text."""
    words = open(path, encoding="ascii").read().split()
    at, text = 1, []
    for _ in range(int(words[0])):
        m, n = int(words[at]), int(words[at + 1])
        at += 2
        rows = [" ".join(words[at + 3 * i:at + 3 * i + 3]) for i in range((m + 1) * (n + 1))]
        at += 3 * (m + 1) * (n + 1)
        knots = ["%d %d" % (d + 1, d + 1) + "\n" + " ".join(["0"] * (d + 1) + ["1"] * (d + 1)) for d in (m, n)]
        text.append("\n".join(["200 1 0 0", "3 0"] + knots + rows) + "\n")
    return "".join(text)


def hill(at, side, rise):
    """One bicubic square round (at, 0) that rises by twice this in its middle."""
    bend = (0, 4 / 3, 4 / 3, 0)
    knots = "4 4\n0 0 0 0 1 1 1 1"
    rows = ["%.17g %.17g %.17g" % (at + side * (i / 3 - 0.5), side * (j / 3 - 0.5), rise * (bend[i] + bend[j]))
            for j in range(4) for i in range(4)]
    return "\n".join(["200 1 0 0", "3 0", knots, knots] + rows) + "\n"


def part(folder, name, chosen):
    """The splines of a built-in tile whose numbers are chosen."""
    with open(os.path.join(folder, "tiles", name.split("@")[0], name + ".g2"), encoding="ascii") as file:
        splines = file.read().split("200 1 0 0")[1:]
    return "".join("200 1 0 0" + s for i, s in enumerate(splines) if chosen(i))


def parts(data):
    """Tiles in parts of several colours: horns and stems without their sheet, scales in the middle of a cell."""
    return {
        "skin.g2": "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n",
        "thorn-horn.g2": part(data, "thorn", lambda i: i == 0),
        "thorn-sheet.g2": part(data, "thorn", lambda i: i > 0),
        "flower-stem.g2": part(data, "flower", lambda i: i == 0),
        "flower-stem@bloom.g2": part(data, "flower@bloom", lambda i: i == 0),
        "flower-sheet.g2": part(data, "flower", lambda i: i > 0),
        "scale-middle.g2": part(data, "scale", lambda i: i % 2 == 0),
        "scale-side.g2": part(data, "scale", lambda i: i % 2 == 1),
    }


def main(data, folder):
    teapot = os.path.join(data, "teapot.bpt")
    scenes = {
        "chess.g2": revolved(PAWN, (-1.4, -0.3, 0)) + revolved(BISHOP, (1.4, 0.3, 0)),
        "wicker.g2": (bezier_patches(teapot) + revolved(GLASS, (-4.8, -1.3, -0.1), 0.66)
                      + revolved(GLASS, (-2.2, -3.3, -0.1), 0.66)),
        "vases.g2": revolved(VASE, (-1.8, 0, 0)) + revolved(BOTTLE, (1.6, 0.2, 0)),
        "hills.g2": "".join(hill(2.3 * k, 2, 0.25) for k in range(5)),
    }
    scenes.update(("tiles/" + name, text) for name, text in parts(data).items())
    for name, text in scenes.items():
        with open(os.path.join(folder, name), "w", encoding="ascii") as out:
            out.write(text)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: model_bases.py DATA FOLDER")
    main(sys.argv[1], sys.argv[2])
