// SPDX-License-Identifier: Apache-2.0
// Help texts: examples first, then what each option means. docs/knurl.1 says the same at more length.
#include "cli/cli.h"

#include <string.h>

static const char overview[] =
    "knurl puts geometry on geometry: exact NURBS textures for CAD, meshes for print and rendering.\n"
    "\n"
    "  knurl apply teapot.bpt --tile chain --size 0.3 -o teapot.step -o teapot.glb\n"
    "  knurl apply grip.g2 --tile knurl --count 48,12 --height 0.4 --dry-run\n"
    "  knurl check teapot.bpt --height 0.2 -o heat.png\n"
    "  knurl tiles\n"
    "  knurl info teapot.bpt\n"
    "  knurl eval teapot.bpt --patch 4 --at 0.5,0.5 --derivatives 1\n"
    "  knurl render teapot.glb -o teapot.png\n"
    "\n"
    "commands:\n"
    "  apply    compose a tile over every cell of a base and write the result\n"
    "  slice    contours of the textured base, layer by layer\n"
    "  check    say how high a texture may be before the base folds or meets itself\n"
    "  tiles    list the built-in tiles\n"
    "  info     say what is in a file\n"
    "  eval     evaluate a spline, or the shell over a surface\n"
    "  render   make a picture\n"
    "  animate  a texture that changes with time\n"
    "\n"
    "'knurl COMMAND --help' says more; 'knurl --version' says which this is.\n"
    "exit: 0 ok, 1 failure, 2 usage, 3 bad input, 4 a check failed, 5 cancelled\n";

static const char apply[] =
    "knurl apply BASE --tile TILE -o OUT [-o OUT ...]\n"
    "\n"
    "  knurl apply teapot.bpt --tile chain --size 0.3 -o teapot.step -o teapot.glb\n"
    "  knurl apply grip.g2 --tile knurl --count 48,12 --height 0.4 --json -o grip.step\n"
    "  knurl apply vase.g2 --tile scale --size 2,3 --dry-run\n"
    "  knurl apply recipe.json\n"
    "\n"
    "BASE is a .bpt or .g2 file (all its surfaces and volumes are textured) or a recipe in JSON.\n"
    "OUT's ending picks the writer: .step .stp .stl .obj .glb .gltf\n"
    "\n"
    "what and where:\n"
    "  -t, --tile TILE         a built-in name ('knurl tiles') or a .g2 or .bpt file\n"
    "      --tile-cell U0,V0,U1,V1   the cell in a tile file's coordinates (default 0,0,1,1)\n"
    "  -c, --count NU[,NV]     cells over each surface\n"
    "  -s, --size L[,L]        wanted cell size; counts agree on shared edges\n"
    "      --spacing uniform|even|free   equal steps of the parameters, even in length, or corners free in both\n"
    "                          (default: even in directions with a size, uniform in those with a count)\n"
    "      --rows              rows of cells may have different counts, where a surface narrows\n"
    "      --stretch           heights follow the size of the cells\n"
    "      --height H          height of w = 1 above the base (negative: below)\n"
    "      --offset H          lifts the whole texture by H\n"
    "      --side above|below|both   w = 0 .. 1 from 0 to H, from 0 to -H, or from -H to H\n"
    "      --rotate DEG        turns the tile in its cell (multiples of 90)\n"
    "lengths (size, height, offset, tol) may name their unit: 3mm, 0.5cm, 1in\n"
    "which shell:\n"
    "      --direction X,Y,Z|FILE.g2      instead of the normal\n"
    "      --thickness X|FILE.g2          the height counts in it\n"
    "      --attraction X,Y,Z|FILE.g2     pulls by that times w to the power of\n"
    "      --attraction-power K           2 unless said\n"
    "      a file holds one surface over (u,v): three components, or one for a thickness\n"
    "how exactly:\n"
    "      --normal fitted|exact-direction   how the unit normal is represented\n"
    "      --normal-tol E      its certified error (default 1e-6)\n"
    "      --max-degree N      highest degree written: a number, occt (25, the default), catia (15), vda (11), "
    "exact\n"
    "      --tol L             chord height of the meshes\n"
    "      --cells-tol L       how far free corners may change the surface (default: 1e-4 of a cell)\n"
    "      --symbolic          compose each cell symbolically (slow, the reference)\n"
    "running:\n"
    "  -o, --output OUT        may be given many times\n"
    "      --unit mm|cm|m|in   unit of the base (default mm)\n"
    "  -j, --threads N         default: all processors; the result does not depend on it\n"
    "  -n, --dry-run           plan and report, write nothing\n"
    "      --json              one JSON object on standard output\n"
    "  -q, --quiet             no progress, no summary\n";

static const char check[] =
    "knurl check BASE --height H [--tile TILE] [-o heat.png] [-o heat.glb]\n"
    "\n"
    "  knurl check teapot.bpt --height 0.2 -o heat.png\n"
    "  knurl check teapot.bpt --height 0.2 --side both --json\n"
    "  knurl check grip.g2 --tile thorn --size 4mm --height 3mm\n"
    "\n"
    "Says whether S + w n folds for heights from 0 to H, how far each cell may rise above and below before it does,\n"
    "and whether two places of the base reach the same point. All of it is certified; what cannot be is said to be "
    "so.\n"
    "With a tile only the region that its patches occupy counts. Exit code 4 unless everything is certified free.\n"
    "\n"
    "      --height H          as in apply, with --offset and --side; a volume brings its own\n"
    "  -t, --tile TILE         with --tile-cell, --count, --size, --spacing, --rows, --stretch, --rotate as in "
    "apply\n"
    "      --direction, --thickness, --attraction, --attraction-power, --normal, --normal-tol   as in apply\n"
    "  -o, --output OUT        .png: a picture with a legend; .glb .gltf: the base with colours; may be given many "
    "times\n"
    "      --pixels W,H        of the picture (default 1280,960)\n"
    "      --color safe-height|jacobian   what they show\n"
    "      --work N            boxes to visit in search of two places with one image (default 100000)\n"
    "      --unit mm|cm|m|in   unit of the base (default mm)\n"
    "      --json              one JSON object on standard output\n"
    "  -j, --threads N         default: all processors; the answer does not depend on it\n"
    "  -q, --quiet             no progress, no report: the exit code alone\n";

static const char slice[] =
    "knurl slice BASE --tile TILE --layer L -o OUT [options]\n"
    "knurl slice RECIPE.json --layer L -o OUT [options]\n"
    "\n"
    "  knurl slice vase.g2 --tile knurl --size 4mm --layer 0.2mm -o vase.3mf\n"
    "  knurl slice teapot.bpt --tile scale --count 6 --layer 0.05 --from 0.5 --to 1 -o layers/pot.svg\n"
    "\n"
    "Contours of the textured base, layer by layer, in the middle of each; only cells near a layer are composed.\n"
    "Options of the texture as in apply.\n"
    "\n"
    "  -l, --layer L           thickness of a layer\n"
    "      --from Z --to Z     layers between these heights (default: all of the object)\n"
    "      --tol L             of contours (default: a twentieth of a layer)\n"
    "  -o, --output OUT        .svg: a drawing for each layer, OUT-0001.svg and so on; .3mf: one file with the "
    "slice\n"
    "                          extension; may be given many times\n"
    "      --json              one JSON object on standard output\n"
    "  -j, --threads N         default: all processors; files do not depend on it\n"
    "  -q, --quiet             no progress, no report\n";

static const char tiles[] = "knurl tiles [--json]\n"
                            "\n"
                            "  knurl tiles --json\n"
                            "  knurl tiles\n"
                            "\n"
                            "Lists the built-in tiles: name, kind, patches in a cell, and what it looks like.\n";

static const char info[] =
    "knurl info FILE [--json]\n"
    "\n"
    "  knurl info teapot.bpt\n"
    "  knurl info teapot.glb --json\n"
    "\n"
    "Format, counts, degrees and bounding box of a .bpt, .g2, .glb or .gltf file; creases, poles\n"
    "and apexes of surfaces.\n";

static const char eval[] =
    "knurl eval FILE --at U,V[,W] [--at ...] [--patch K] [--derivatives N] [--json]\n"
    "\n"
    "  knurl eval teapot.bpt --patch 4 --at 0.5,0.5\n"
    "  knurl eval teapot.bpt --patch 4 --at 0.5,0.5 --derivatives 2\n"
    "  knurl eval teapot.bpt --patch 4 --at 0.5,0.5,0.1     the shell S + w n at w = 0.1\n"
    "\n"
    "      --at U,V[,W]        parameters, as many as the spline has; one more for the shell\n"
    "      --patch K           which spline of the file, from 0\n"
    "      --derivatives N     all partials up to order N: f, f_u, f_v, f_uu, f_uv, f_vv, ...\n"
    "      --normal-tol E      of the shell's normal (default 1e-6)\n"
    "      --json              numbers with their parameters\n";

static const char render[] = "knurl render IN -o OUT.png\n"
                             "\n"
                             "  knurl render teapot.glb -o teapot.png\n"
                             "  knurl render teapot.bpt --width 800 --height 600 -o plain.png\n"
                             "\n"
                             "IN is a .glb, .gltf, .bpt or .g2 file. The camera frames it by itself.\n"
                             "\n"
                             "      --width N --height N   pixels (default 1600 x 1200)\n"
                             "      --samples N            paths per pixel\n"
                             "      --azimuth DEG          where the camera stands\n"
                             "      --elevation DEG\n"
                             "  -j, --threads N            the picture does not depend on it\n"
                             "  -q, --quiet                no progress\n";

static const char animate[] =
    "knurl animate BASE|RECIPE --tile TILE --vary NAME=VALUE .. -o OUT.glb|OUT.png|OUT.mp4\n"
    "\n"
    "  knurl animate vase.g2 --tile thorn --count 12,8 --vary 'bend=0.8*sin(6.28*{t}+3*z)' -o wind.glb\n"
    "  knurl animate vase.g2 --tile scale --count 12,8 --vary 'lift={t}' --frames 50 -o film.mp4\n"
    "\n"
    "{t} in a value of --vary is time, from 0 to 1. A glTF file has morph targets, a .png one picture a frame\n"
    "(OUT-0001.png ..), a .mp4 those and a video of them by ffmpeg. Options of textures are those of apply.\n"
    "\n"
    "      --frames N             (default 25)\n"
    "      --seconds S            how long it is (default 2)\n"
    "      --picture-width N --picture-height N   pixels (default 800 x 600)\n"
    "      --samples N --azimuth DEG --elevation DEG   as for render\n";

int cli_help(FILE *to, const char *command)
{
    static const struct {
        const char *name, *text;
    } texts[] = {{"apply", apply}, {"check", check}, {"slice", slice},   {"tiles", tiles},
                 {"info", info},   {"eval", eval},   {"render", render}, {"animate", animate}};
    if (!command) return fputs(overview, to) < 0 ? EXIT_FAILED : EXIT_OK;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if (strcmp(command, texts[i].name) == 0) return fputs(texts[i].text, to) < 0 ? EXIT_FAILED : EXIT_OK;
    cli_error("no help for '%s'", command);
    cli_usage_hint(NULL);
    return EXIT_USAGE;
}
