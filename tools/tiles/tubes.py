# SPDX-License-Identifier: Apache-2.0
"""Strands: tubes about quadratic paths."""
import math

from base import Surface, add, mid, q


def sub(a, b):
    return tuple(x - y for x, y in zip(a, b))


def times(k, a):
    return tuple(k * x for x in a)


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a):
    return times(1 / math.sqrt(dot(a, a)), a)


def polygon(n, radius):
    """A control polygon whose closed quadratic is nearly a circle of this radius: within 6 % for four sides, 1.3 % for
    six, 0.4 % for eight; the first corner is to the right of the seam."""
    r = radius / math.cos(math.pi / n)
    return [(r * math.cos(a), r * math.sin(a)) for a in (math.pi / n * (2 * k + 1) for k in range(n))]


def rings(path, section, before, after, up=(0, 0, 1), planes={}, mitre=1.0):
    """A ring of control points about each control point of the path, which came from `before` and goes on to `after`.
    section holds (x, y): y towards `up`, x to the left of the path. The rings are mitred: they lie in the planes that
    halve the corners of the path, so that the strand is as thick everywhere; planes = {index: normal} chooses others. A
    path that is all corners gets too thick in them: then a mitre of 1/2 shares the error between corners and legs."""
    whole = [before] + list(path) + [after]
    out = []
    for i, p in enumerate(path):
        t0, t1 = unit(sub(p, whole[i])), unit(sub(whole[i + 2], p))
        t = unit(add(t0, t1))
        left = unit(cross(up, t))
        high = cross(t, left)
        bend, stretch = sub(t1, t0), (2 / math.sqrt(dot(add(t0, t1), add(t0, t1)))) ** mitre - 1
        ring = []
        for x, y in section(i) if callable(section) else section:
            o = add(times(x, left), times(-y, high))
            if dot(bend, bend) > 1e-12:
                n = unit(bend)
                o = add(o, times(stretch * dot(o, n), n))
            m = planes.get(i)
            if m:
                o = sub(o, times(dot(o, m) / dot(t, m), t))
            ring.append(add(p, o))
        out.append(ring)
    return out


def in_cell(net, aspect, z0):
    return [[(q(p[0]), q(p[1]), q((p[2] - z0) / aspect)) for p in ring] for ring in net]


def strand(path, section, shift, **options):
    """The tube about a path that goes on in the next cell, moved by shift."""
    net = rings(path, section, sub(path[-1], shift), add(path[0], shift), **options)
    return Surface(net, cyclic=(shift, True))


def piece(net, first, last, move=(0, 0, 0)):
    """Of a longer tube, rings in the cell: from midway before ring `first` to midway behind ring `last`."""
    halfway = lambda i: [mid(a, b) for a, b in zip(net[i], net[i + 1])]
    part = [halfway(first - 1)] + net[first:last + 1] + [halfway(last)]
    return Surface([[add(p, move) for p in ring] for ring in part], cyclic=(False, True))
