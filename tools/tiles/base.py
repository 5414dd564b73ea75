# SPDX-License-Identifier: Apache-2.0
"""What all tiles are made of: curves, surfaces and volumes with their control nets, and the register of tiles.

Every tile is modelled in real proportions, cell width 1, and written in cell coordinates (u, v, w), w = z / aspect.
Control points are multiples of 2^-12 (midpoints of them where a closed curve is clamped) and knots are integers, so
that splitting at knots, mirroring and translating by whole cells are exact in binary, and edges that belong together
are equal bit for bit.
"""
import importlib
import inspect
import itertools
import math

GRID = 4096
MODULES = ["mail", "scales", "relief", "hair", "weaves", "grips", "floors", "lattices", "creatures"]
TILES = []  # in the order of registration, which is the order of the library


class Tile:
    """A row of the library's table; model(**parameters) gives {part: [splines]} in cell coordinates."""

    def __init__(self, model, name, about, aspect, materials, covering, parameters):
        self.model, self.name, self.about, self.aspect = model, name, about, aspect
        self.materials = materials  # {part: ((red, green, blue), metallic, roughness)}, in the order of the parts
        self.covering = covering
        self.parameters = parameters  # {name: (target, lowest, highest)}; the value is the default of the argument

    def value(self, parameter):
        return inspect.signature(self.model).parameters[parameter].default


def tile(name, about, aspect, materials, covering=False, parameters=None):
    """Registers the function below as a tile."""
    def register(model):
        TILES.append(Tile(model, name, about, aspect, materials, covering, parameters or {}))
        return model
    return register


def q(x):
    """The nearest multiple of 2^-12."""
    return round(x * GRID) / GRID


def mid(a, b):
    return tuple((x + y) / 2 for x, y in zip(a, b))


def add(a, b):
    return tuple(x + y for x, y in zip(a, b))


def clamped(degree, spans):
    return [0] * (degree + 1) + list(range(1, spans)) + [spans] * (degree + 1)


def closed(points, degree=2, shift=(0, 0, 0)):
    """Clamped control points of the closed curve with these control points, one span for each: the polygon of degree
    1, or the C1 quadratic, which starts midway between the last and the first. Each round is moved by shift: with
    whole cells, a curve that goes on in the next cell."""
    if degree == 1:
        return list(points) + [add(points[0], shift)]
    assert degree == 2
    seam = mid(add(points[-1], tuple(-c for c in shift)), points[0])
    return [seam] + list(points) + [add(seam, shift)]


def square(a):
    """A control square whose closed quadratic is nearly a circle of radius a, the seam at (a, 0)."""
    return [(a, a), (-a, a), (-a, -a), (a, -a)]


def load():
    """Registers the tiles of all modules."""
    for module in MODULES:
        importlib.import_module(module)


class Spline:
    """Control points over one, two or three variables, the last fastest; sizes counts them, degree and cyclic say how
    they are read: integer knots, as smooth as the degree allows, cyclic ones (of degree 1 or 2) without a seam. Instead
    of True, cyclic may say by which cells, (u, v, 0), a round moves."""

    KIND = {1: 100, 2: 200, 3: 700}

    def __init__(self, points, sizes, degree, cyclic):
        self.points, self.sizes, self.degree, self.cyclic = list(points), tuple(sizes), tuple(degree), tuple(cyclic)
        assert len(self.points) == math.prod(self.sizes)

    def map(self, f):
        return Spline([f(p) for p in self.points], self.sizes, self.degree, self.cyclic)

    def in_cell(self, aspect, z0=0.0):
        return self.map(lambda p: (q(p[0]), q(p[1]), q((p[2] - z0) / aspect)))

    def along(self, k, f):
        """f applied to every line of control points in variable k; only a closing f may change how many there are."""
        n, stride = self.sizes[k], math.prod(self.sizes[k + 1:])
        blocks = []
        for o in range(math.prod(self.sizes[:k])):
            lines = [f([self.points[(o * n + j) * stride + i] for j in range(n)]) for i in range(stride)]
            blocks += [line[j] for j in range(len(lines[0])) for line in lines]
        sizes = self.sizes[:k] + (len(lines[0]),) + self.sizes[k + 1:]
        return Spline(blocks, sizes, self.degree, self.cyclic)

    def reversed(self, k=-1):
        """The other way along variable k: a surface then faces the other way."""
        return self.along(k % len(self.sizes), lambda line: line[::-1])

    def clamped(self):
        """The same with clamped ends: nothing is cyclic any more."""
        s = self
        for k, d in enumerate(self.degree):
            if self.cyclic[k]:
                shift = (0, 0, 0) if self.cyclic[k] is True else self.cyclic[k]
                s = s.along(k, lambda line, d=d, shift=shift: closed(line, d, shift))
        return Spline(s.points, s.sizes, s.degree, [False] * len(s.sizes))

    def at(self, *index):
        flat = 0
        for i, n in zip(index, self.sizes):
            flat = flat * n + i % n
        return self.points[flat]

    def g2(self):
        s = self.clamped()
        lines = ["%d 1 0 0" % self.KIND[len(s.sizes)], "3 0"]
        for n, d in zip(s.sizes, s.degree):
            lines += ["%d %d" % (n, d + 1), " ".join(map(str, clamped(d, n - d)))]
        for index in itertools.product(*[range(n) for n in reversed(s.sizes)]):  # the file has the first fastest
            lines.append(" ".join(repr(float(c)).removesuffix(".0") for c in s.at(*index[::-1])))
        return "\n".join(lines) + "\n"


def Curve(net, degree=2, cyclic=False):
    """net[i]: the control point for r = i."""
    return Spline([tuple(p) for p in net], [len(net)], [degree], [cyclic])


def Surface(net, degree=(2, 2), cyclic=(False, False)):
    """net[i][j]: the control point for r = i, t = j; oriented outwards by r x t."""
    net = [list(row) for row in net]
    return Spline([tuple(p) for row in net for p in row], [len(net), len(net[0])], degree, cyclic)


def Volume(net, degree=(1, 1, 1), cyclic=(False, False, False)):
    """net[i][j][k]: right-handed, so that the determinant of the derivatives is positive."""
    net = [[list(line) for line in sheet] for sheet in net]
    sizes = [len(net), len(net[0]), len(net[0][0])]
    return Spline([tuple(p) for sheet in net for line in sheet for p in line], sizes, degree, cyclic)
