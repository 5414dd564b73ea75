#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the built-in tiles: python3 tools/tiles data/tiles io/builtin_table.h

The first is the folder of the geometry, <tile>/<part>.g2 and, where a parameter of the tile changes the part,
<tile>/<part>@<parameter>.g2: the part with the parameter at its target. What is in the folder of a tile and no longer
belongs there is removed. The second is the table of names, materials and parameters, which io/builtin_tile.c
includes.

A new tile is a function with @tile above it (base.py); a new module is named there too.
"""
import os
import sys

sys.dont_write_bytecode = True
from base import GRID, TILES, load


def check(name, part, at_value, at_target, halfway):
    """The target has the same shape, and halfway the control points are halfway, within what rounding them to the
    grid allows."""
    for s, t, h in zip(at_value, at_target, halfway, strict=True):
        assert s.sizes == t.sizes == h.sizes and s.degree == t.degree and s.cyclic == t.cyclic, (name, part)
        for p, x, m in zip(s.points, t.points, h.points):
            for c in range(3):
                assert abs((p[c] + x[c]) / 2 - m[c]) <= 2.5 / GRID, (name, part, p, x, m)


def files(tile):
    """{path: text} of one tile."""
    model = tile.model()
    assert list(model) == list(tile.materials), tile.name
    texts = {"%s/%s.g2" % (tile.name, part): "".join(s.g2() for s in splines) for part, splines in model.items()}
    for name, (target, lowest, highest) in tile.parameters.items():
        value = tile.value(name)
        assert lowest <= value <= highest and lowest <= target <= highest and target != value, (tile.name, name)
        other, halfway = tile.model(**{name: target}), tile.model(**{name: (value + target) / 2})
        for part, splines in model.items():
            check(tile.name, part, splines, other[part], halfway[part])
            text = "".join(s.g2() for s in other[part])
            if text != texts["%s/%s.g2" % (tile.name, part)]:
                texts["%s/%s@%s.g2" % (tile.name, part, name)] = text
    return texts


def row(tile):
    number = lambda x: repr(float(x))
    lines = ['{.name = "%s",' % tile.name, ' .about = "%s",' % tile.about, " .aspect = %s," % number(tile.aspect)]
    parts = ['{"%s", {{%s}, %s, %s}}' % (part, ", ".join(map(number, color)), number(metallic), number(roughness))
             for part, (color, metallic, roughness) in tile.materials.items()]
    lines += [" .part = (const part_source[]){%s}," % (",\n" + 31 * " ").join(parts), " .nparts = %d," % len(parts)]
    parameters = ['{"%s", %s}' % (name, ", ".join(map(number, (tile.value(name),) + tile.parameters[name])))
                  for name in tile.parameters]
    if parameters:
        lines += [" .parameter = (const kn_tile_parameter[]){%s}," % (",\n" + 42 * " ").join(parameters),
                  " .nparameters = %d," % len(parameters)]
    return "\n".join(lines + [" .covering = true}," if tile.covering else " .covering = false},"])


def table(tiles):
    return "\n".join(["// SPDX-License-Identifier: Apache-2.0",
                      "// Made by tools/tiles; do not edit. The rows of io/builtin_tile.c's table.",
                      "// clang-format off",
                      *[row(t) for t in tiles], ""])


def write(path, text):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="ascii") as out:
        out.write(text)


def main(folder, header):
    load()
    wanted = {}
    for tile in TILES:
        wanted |= files(tile)
    for path, text in wanted.items():
        write(os.path.join(folder, path), text)
    for tile in TILES:
        for name in os.listdir(os.path.join(folder, tile.name)):
            if "%s/%s" % (tile.name, name) not in wanted:
                os.remove(os.path.join(folder, tile.name, name))
    write(header, table(TILES))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit("usage: python3 tools/tiles FOLDER HEADER")
    main(sys.argv[1], sys.argv[2])
