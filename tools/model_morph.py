#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# model_morph.py FOLDER: writes pebble.obj and star.obj, two closed bodies of different triangles in the unit cell.
import math
import sys


def body(path, around, rings, point):
    """Circles of `around` points, each turned half a step against the one below, and two poles."""
    points = [point(math.pi * (r + 1) / (rings + 1), 2 * math.pi * (k + 0.5 * (r % 2)) / around)
              for r in range(rings) for k in range(around)]
    bottom, top = len(points), len(points) + 1
    points += [point(0.0, 0.0), point(math.pi, 0.0)]
    triangles = []
    for k in range(around):
        m = (k + 1) % around
        triangles.append((bottom, m, k))
        for r in range(rings - 1):
            a, b, c, d = r * around + k, r * around + m, (r + 1) * around + k, (r + 1) * around + m
            triangles += [(a, b, d), (a, d, c)]
        triangles.append(((rings - 1) * around + k, (rings - 1) * around + m, top))
    with open(path, "w", encoding="ascii") as out:
        out.writelines("v %.5f %.5f %.5f\n" % p for p in points)
        out.writelines("f %d %d %d\n" % tuple(i + 1 for i in t) for t in triangles)


def pebble(a, b):
    return (0.5 + 0.34 * math.sin(a) * math.cos(b), 0.5 + 0.34 * math.sin(a) * math.sin(b), 0.28 - 0.28 * math.cos(a))


def star(a, b):
    r = 0.16 + 0.3 * abs(math.cos(2.5 * b)) ** 6 * math.sin(a) ** 2
    x, y = r * math.sin(a) * math.cos(b), r * math.sin(a) * math.sin(b)
    return (0.5 + x, 0.5 + y, 0.25 - 0.25 * math.cos(a) + 1.2 * max(0.0, r - 0.2) * math.sin(a))


folder = sys.argv[1]
body(folder + "/pebble.obj", 24, 12, pebble)
body(folder + "/star.obj", 40, 14, star)
