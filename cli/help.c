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
    "  convert  write a model as another kind of file\n"
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
    "  knurl apply part.step --faces name:grip --tile knurl --count 36,5 --height 0.7 --taper 1.5 -o knurled.step\n"
    "  knurl apply recipe.json\n"
    "\n"
    "BASE is a .bpt, .g2 or .itd file (all its surfaces and volumes are textured), a CAD file (.step .stp .igs "
    ".iges\n"
    ".brep: --faces chooses) or a recipe in JSON, which may have several layers.\n"
    "OUT's ending picks the writer: .step .stp .stpz .igs .iges .g2 .itd .3dm .vtu .mesh .pov .stl .obj .glb .gltf\n"
    "\n"
    "what and where:\n"
    "  -t, --tile TILE         a built-in name ('knurl tiles'), a description (.json), splines (.g2 .itd .bpt)\n"
    "                          or a mesh (.obj .stl .ply .off .glb .gltf .3mf)\n"
    "      --tile-cell U0,V0,U1,V1   the cell in a tile file's coordinates (default 0,0,1,1)\n"
    "      --morph TILE        what the tile turns into: its parameter \"morph\" goes from 0 to 1 (--vary morph=..)\n"
    "  -c, --count NU[,NV]     cells over each surface\n"
    "  -s, --size L[,L]        wanted cell size; counts agree on shared edges\n"
    "      --spacing uniform|even|free   equal steps of the parameters, even in length, or corners free in both\n"
    "                          (default: even in directions with a size, uniform in those with a count)\n"
    "      --rows              rows of cells may have different counts, where a surface narrows\n"
    "      --stretch           heights follow the size of the cells\n"
    "      --height H          height of w = 1 above the base (negative: below)\n"
    "      --offset H          lifts the whole texture by H\n"
    "      --side above|below|both   w = 0 .. 1 from 0 to H, from 0 to -H, or from -H to H\n"
    "      --rotate DEG        turns the tile in its cell; tiles that cover by multiples of 90\n"
    "lengths may name their unit: 3mm, 0.5cm, 1in\n"
    "placement, faces of CAD files (--faces), variation: 'knurl help placement'\n"
    "which shell:\n"
    "      --direction X,Y,Z|FILE.g2      instead of the normal\n"
    "      --thickness X|FILE.g2          the height counts in it\n"
    "      --attraction X,Y,Z|FILE.g2     pulls by that times w to the power of\n"
    "      --attraction-power K           2 unless said\n"
    "      a file holds one surface over (u,v): three components, or one for a thickness\n";

static const char exactly[] = // no string is longer than 4095 bytes
    "how exactly:\n"
    "      --normal fitted|exact-direction   how the unit normal is represented\n"
    "      --normal-tol E      its certified error (default 1e-6)\n"
    "      --max-degree N      of faces in CAD files: 3 .. 56, occt (25, the default), catia (15), vda (11), cubic\n"
    "                          or exact; what is above becomes a spline within --tol, certified (docs/limits.md)\n"
    "      --tol L             of those (default 0.01mm), and chord height of the meshes (a hundredth of a cell)\n"
    "      --seam-angle DEG    smooth seams of those stay so within this angle, certified (default 1)\n"
    "      --body replace|cover|none   of a CAD base, in STEP: the texture takes the place of the faces it covers\n"
    "                          (the default where the body stays closed), lies over them, or goes out alone\n"
    "      --merge             one face where patches form a smooth grid\n"
    "      --step ap214|ap242|ap203   the protocol of STEP files (default: ap214)\n"
    "      --instances         an assembly in STEP files: cells that are equal, turned and shifted, once\n"
    "      --cells-tol L       how far free corners may change the surface (default: 1e-4 of a cell)\n"
    "      --crossing refuse|trim|approximate   of tiles across knot lines of the base: an error (the default), "
    "pieces\n"
    "                          trimmed along the line, or patches within\n"
    "      --crossing-tol L    1e-3 of a cell unless said\n"
    "      --symbolic          compose each cell symbolically (slow, the reference)\n"
    "running:\n"
    "  -o, --output OUT        may be given many times\n"
    "      --unit mm|cm|m|in   unit of the base (default mm)\n"
    "  -j, --threads N         default: all processors; the result does not depend on it\n"
    "  -n, --dry-run           plan and report, write nothing\n"
    "      --resume            keep a journal (OUT.journal), and go on from it after an interruption; no .glb\n"
    "      --obj-surfaces      exact curves and surfaces in .obj files, not triangles\n"
    "      --json              one JSON object on standard output\n"
    "  -q, --quiet             no progress, no summary\n";

static const char placement[] =
    "knurl apply BASE --tile TILE [where tiles lie] [which cells there are] [what varies] -o OUT\n"
    "\n"
    "  knurl apply wall.g2 --tile brick --size 4,2 --stagger 0.5 -o wall.step\n"
    "  knurl apply teapot.bpt --tile scale --size 0.3 --mask 'z > 1' --vary 'height=1+noise(x,y,z)' -o teapot.stl\n"
    "\n"
    "where tiles lie:\n"
    "      --shift U[,V]       of all tiles, in cells\n"
    "      --stagger U[,V]     each next row by so many cells in u (bricks: 0.5; or 1/3), each next column in v\n"
    "      --mirror u|v|uv     every second column, row, or both\n"
    "      --border extend|clip|cyclic[,..]   what reaches beyond open ends: over the extended surface, cut off\n"
    "                          (trimmed within --crossing-tol), or in at the other end\n"
    "      --trimmed keep|clip|taper   over the border of a trimmed face: whole, cut off (within --crossing-tol),\n"
    "                          or with heights that fall off (--taper; one cell)\n"
    "      --scatter L         tiles at random places at least L apart, in place of one in each cell\n"
    "which cells there are (all that is said must hold):\n"
    "      --mask FIELD        where it is above 0.5\n"
    "      --faces 0,3,5-9     on these surfaces of the base; of a CAD file also name:TEXT, body:TEXT,\n"
    "                          type:cylinder, color:#rrggbb, near:X,Y,Z ('knurl info FILE' lists them); '+' joins,\n"
    "                          '&' is both\n"
    "      --join-angle DEG    faces of a CAD file that meet within this angle along whole sides are one domain\n"
    "                          (1); heights fall off towards other edges between faces\n"
    "      --no-join           each face by itself\n"
    "      --within-angle AXIS,DEG   the normal this near to x, -z .. or X,Y,Z\n"
    "      --skip N[,M]        every N-th only\n"
    "      --density P         this share of them, by chance\n"
    "      --slab Z0,Z1        that may touch heights from Z0 to Z1\n"
    "      --range FIRST[,N]   by their numbers in the job's order\n"
    "      --seed N            of all that is left to chance\n"
    "      --camera X,Y,Z,X,Y,Z[,DEG]   in the picture of this eye, which looks at the second point\n"
    "      --picture W,H --least-pixels N --hidden   its pixels; cells that are smaller, or behind the base, go\n"
    "variation:\n"
    "      --vary NAME=FIELD   a parameter of the tile, in its range (knurl tiles --json), or height (a factor)\n"
    "                          or offset, over the base; many times\n"
    "      --set NAME=X        the same everywhere\n"
    "      --taper L           heights end at open ends and at borders of the mask, from L away on\n"
    "      --jitter angle=DEG,shift=X,scale=X,height=X   by chance, up to so much; any of them\n"
    "colours, one for each cell:\n"
    "      --color FIELD       at its middle, from 0 to 1: '0.5+noise(x,y,z)'\n"
    "      --palette NAME|C,C,..   ember (unless said) gray gold copper moss sea coral ivory autumn rainbow, or "
    "rrggbb,..\n"
    "      --color-steps N     so many colours of it (default 16)\n"
    "      --color-part NAME[,..]   parts of the tile that have them; the others keep theirs (default: all)\n"
    "a FIELD is a number, a .g2 file with one surface over (u,v), a .png (black 0, white 1), or an expression of u v "
    "x "
    "y z\n"
    "nx ny nz mean gauss face with sin .. noise(x,y,z) smooth(a,b,x) clamp mix mod: 'u > 0.5 && noise(x,y,z) > 0'\n";

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
    "  -t, --tile TILE         with --tile-cell, --count, --size, --spacing, and all that places, varies and\n"
    "                          chooses it as in apply: cells without a tile do not count\n"
    "      --layer N           of a recipe with several layers\n"
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
    "  -o, --output OUT        .svg: a drawing for each layer, OUT-1.svg and so on; .3mf: one file with the "
    "slice\n"
    "                          extension; may be given many times\n"
    "      --json              one JSON object on standard output, with the certified error, gaps and doubts\n"
    "  -j, --threads N         default: all processors; files do not depend on it\n"
    "  -q, --quiet             no progress, no report\n";

static const char tiles[] =
    "knurl tiles [--json]\n"
    "knurl tiles --check TILE [--tile-cell U0,V0,U1,V1] [--json]\n"
    "\n"
    "  knurl tiles --json\n"
    "  knurl tiles --check scale\n"
    "\n"
    "Lists the built-in tiles: name, kind, patches in a cell, and what it looks like. With --check: what is proved "
    "of\n"
    "one of them, or of a file: where copies in neighbouring cells join and how smoothly, and whether it covers.\n";

static const char info[] =
    "knurl info FILE [--json]\n"
    "\n"
    "  knurl info teapot.bpt\n"
    "  knurl info teapot.glb --json\n"
    "\n"
    "Format, counts, degrees and bounding box of a .bpt, .g2, .itd, .glb or .gltf file; creases, poles\n"
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

static const char convert[] =
    "knurl convert IN -o OUT [-o OUT ..] [options]\n"
    "\n"
    "  knurl convert vase.g2 -o vase.step\n"
    "  knurl convert teapot.bpt --max-degree cubic --tol 0.01mm -o teapot.itd -o teapot.vtu\n"
    "\n"
    "IN is a .bpt, .g2 or .itd file, a CAD file (.step .iges .brep: trimmed faces, each body where it was made), or\n"
    "a mesh (.obj .stl .ply .off .3mf .glb). Splines go out as they are; in STEP and IGES files each becomes one\n"
    "face, cut where it has kinks.\n"
    "\n"
    "  -o, --output OUT        the ending picks the writer, as in apply; may be given many times\n"
    "      --max-degree N|occt|catia|vda|cubic|exact   splines of a higher degree, piece by piece, become others\n"
    "                          within --tol, certified (default: exact)\n"
    "      --tol L             of those, and of triangles (default 0.01mm; triangles a thousandth of the size)\n"
    "      --unit mm|cm|m|in   unit of IN where its format has none (default mm)\n"
    "      --obj-surfaces      curves and surfaces in .obj files, not triangles\n"
    "      --json              one JSON object on standard output\n"
    "  -j, --threads N         default: all processors; files do not depend on it\n"
    "  -q, --quiet             no progress, no report\n";

static const char animate[] =
    "knurl animate BASE|RECIPE --tile TILE --vary NAME=VALUE .. -o OUT.glb|OUT.png|OUT.mp4\n"
    "\n"
    "  knurl animate vase.g2 --tile thorn --count 12,8 --vary 'bend=0.5+0.5*sin(6.28*{t}+3*z)' -o wind.glb\n"
    "  knurl animate vase.g2 --tile scale --count 12,8 --vary 'lift={t}' --frames 50 -o film.mp4\n"
    "\n"
    "{t} in a value of --vary is time, from 0 to 1. A glTF file has morph targets, a .png one picture a frame\n"
    "(OUT-0001.png ..), a .mp4 those and a video of them by ffmpeg. Options of textures are those of apply.\n"
    "\n"
    "      --frames N             (default 25)\n"
    "      --seconds S            how long it is (default 2)\n"
    "      --picture-width N --picture-height N   pixels (default 800 x 600; of videos even)\n"
    "      --samples N --azimuth DEG --elevation DEG   as for render\n"
    "      --json                 one JSON object on standard output\n";

int cli_help(FILE *to, const char *command)
{
    static const struct {
        const char *name, *text, *more;
    } texts[] = {{"apply", apply, exactly},     {"check", check, NULL},     {"slice", slice, NULL},
                 {"tiles", tiles, NULL},        {"info", info, NULL},       {"eval", eval, NULL},
                 {"render", render, NULL},      {"animate", animate, NULL}, {"convert", convert, NULL},
                 {"placement", placement, NULL}};
    if (!command) return fputs(overview, to) < 0 ? EXIT_FAILED : EXIT_OK;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if (strcmp(command, texts[i].name) == 0) {
            const char *more = texts[i].more ? texts[i].more : "";
            return fputs(texts[i].text, to) < 0 || fputs(more, to) < 0 ? EXIT_FAILED : EXIT_OK;
        }
    cli_error("no help for '%s'", command);
    cli_usage_hint(NULL);
    return EXIT_USAGE;
}
