#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the built-in tiles: python3 tools/tiles/sheet.py KNURL DATA WORK OUT [TILE...]

Each tile is laid in rows of cells on the same gently curved square and drawn by `knurl render`: its middle is
OUT/tiles/<tile>.png; OUT/tiles.png shows all of them with their names. Needs rsvg-convert and ffmpeg. What stands on a surface
gets one below it. With names behind them, only those tiles are drawn anew, the others are on the sheet as they were.
"""
import base64
import json
import os
import subprocess
import sys

sys.dont_write_bytecode = True
from base import TILES, load

SIDE, RISE = 4.0, 0.30
PIXELS = (560, 420)  # of a whole picture
CROP = (0.215, 0.2, 0.785, 0.72)  # left, top, right, bottom of what is shown
THUMB = (320, 219)
COLUMNS, LABEL, GAP = 5, 34, 12
COUNT = dict(fur=5, chain=4, rope=4, straight=8, knurl=6, brick=4, rivet=5, dimples=6, studs=6, bump=6, thorn=5,
             leather=2, knit=5, basket=4, wicker1=4, wicker2=3, hexagon=4, bubblewrap=4, scale=5)
SKIN = dict(fur=(0.26, 0.15, 0.07), ant=(0.36, 0.42, 0.24), bird=(0.08, 0.18, 0.32), fish=(0.05, 0.25, 0.28),
            birdfish=(0.20, 0.08, 0.06))
SHEET = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0 0  1 0 0  0 1 0  1 1 0\n"


def base_square():
    """A bicubic square of side SIDE, which rises by RISE along each direction."""
    bend = (0, 2 / 3, 2 / 3, 0)
    lines = ["200 1 0 0", "3 0"] + ["4 4", "0 0 0 0 1 1 1 1"] * 2
    lines += ["%r %r %r" % (SIDE * i / 3, SIDE * j / 3, RISE * (bend[i] + bend[j])) for j in range(4) for i in range(4)]
    return "\n".join(lines) + "\n"


def write(path, text):
    with open(path, "w", encoding="ascii") as out:
        out.write(text)


def description(tile, data):
    """The tile with a skin below it, as a description for --tile."""
    part = lambda name, file, color, metallic, roughness: {
        "name": name, "file": file, "material": {"color": color, "metallic": metallic, "roughness": roughness}}
    parts = [part("skin", "skin.g2", SKIN[tile.name], 0, 0.8)]
    for name, (color, metallic, roughness) in tile.materials.items():
        parts.append(part(name, os.path.join(os.path.abspath(data), tile.name, name + ".g2"), color, metallic, roughness))
    return json.dumps({"format": 1, "kind": "tile", "name": tile.name, "aspect": tile.aspect, "parts": parts})


def draw(knurl, data, work, tile):
    count, source = COUNT.get(tile.name, 4), tile.name
    samples = "24" if any(m[1] > 0.5 for m in tile.materials.values()) else "12"  # metal mirrors the studio
    if tile.name in SKIN:
        source = os.path.join(work, tile.name + ".json")
        write(source, description(tile, data))
    scene, picture = [os.path.join(work, tile.name + ending) for ending in (".glb", ".png")]
    subprocess.run([knurl, "apply", os.path.join(work, "square.g2"), "--tile", source, "--count", "%d,%d" % (count, count),
                    "--normal-tol", "1e-4", "-q", "-o", scene], check=True)
    subprocess.run([knurl, "render", scene, "--width", str(PIXELS[0]), "--height", str(PIXELS[1]), "--samples", samples,
                    "--azimuth", "-25", "--elevation", "48", "-q", "-o", picture], check=True)


def image(path, x, y, size):
    """A picture as an SVG element at (x,y), drawn with this size."""
    with open(path, "rb") as file:
        data = base64.b64encode(file.read()).decode("ascii")
    return '<image x="%g" y="%g" width="%d" height="%d" href="data:image/png;base64,%s"/>' % (x, y, *size, data)


def middle(path):
    """What CROP leaves of a picture of PIXELS, as an SVG element of the size THUMB."""
    left, top, right, bottom = CROP[0] * PIXELS[0], CROP[1] * PIXELS[1], CROP[2] * PIXELS[0], CROP[3] * PIXELS[1]
    return ('<svg width="%g" height="%g" viewBox="%g %g %g %g" preserveAspectRatio="xMidYMid slice">%s</svg>'
            % (*THUMB, left, top, right - left, bottom - top, image(path, 0, 0, PIXELS)))


def svg(work, name, width, height, body):
    path = os.path.join(work, name)
    write(path, '<svg xmlns="http://www.w3.org/2000/svg" width="%d" height="%d"><rect width="100%%" height="100%%" '
          'fill="white"/>%s</svg>' % (width, height, body))
    return path


def convert(path, out):
    subprocess.run(["rsvg-convert", "--unlimited", path, "-o", out], check=True)


def pack(path, width):
    """To this width and 255 colours: a sixth of the bytes."""
    work = path + ".tmp.png"
    subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", path, "-vf",
                    "scale=%d:-1:flags=area,split[a][b];[a]palettegen=max_colors=255[p];"
                    "[b][p]paletteuse=dither=sierra2_4a" % width, work], check=True)
    os.replace(work, path)


def main(knurl, data, work, out, *names):
    load()
    os.makedirs(work, exist_ok=True)
    os.makedirs(os.path.join(out, "tiles"), exist_ok=True)
    write(os.path.join(work, "square.g2"), base_square())
    write(os.path.join(work, "skin.g2"), SHEET)
    body, rows = [], -(-len(TILES) // COLUMNS)
    for k, tile in enumerate(TILES):
        thumb = os.path.join(out, "tiles", tile.name + ".png")
        if not names or tile.name in names:
            draw(knurl, data, work, tile)
            convert(svg(work, "thumb-%s.svg" % tile.name, *THUMB, middle(os.path.join(work, tile.name + ".png"))), thumb)
        x, y = GAP + k % COLUMNS * (THUMB[0] + GAP), GAP + k // COLUMNS * (THUMB[1] + LABEL)
        body.append(image(thumb, x, y, THUMB))
        body.append('<text x="%g" y="%g" font-family="DejaVu Sans" font-size="17" text-anchor="middle" fill="#333">%s</text>'
                    % (x + THUMB[0] / 2, y + THUMB[1] + 22, tile.name))
    size = GAP + COLUMNS * (THUMB[0] + GAP), GAP + rows * (THUMB[1] + LABEL)
    convert(svg(work, "tiles.svg", *size, "".join(body)), os.path.join(out, "tiles.png"))
    pack(os.path.join(out, "tiles.png"), 3 * size[0] // 4)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit("usage: python3 tools/tiles/sheet.py KNURL DATA WORK OUT [TILE...]")
    main(*sys.argv[1:])
