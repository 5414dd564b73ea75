// SPDX-License-Identifier: Apache-2.0
// What the commands of `knurl` share: exit codes, options, the session (context, progress, signals) and outputs.
#ifndef CLI_CLI_H
#define CLI_CLI_H

#include <stdio.h>

#include <knurl/knurl.h>

// The contract of the command line: scripts depend on these numbers.
enum { EXIT_OK = 0, EXIT_FAILED = 1, EXIT_USAGE = 2, EXIT_BAD_INPUT = 3, EXIT_CHECK_FAILED = 4, EXIT_CANCELLED = 5 };

// ---- options ----
typedef enum cli_takes {
    CLI_NOTHING, // a flag
    CLI_TEXT,    // a value
    CLI_FILE,    // one that may name a file: beside the recipe that says so
    CLI_PAIRS,   // NAME=VALUE, in recipes an object
    CLI_FILES,   // the same, where VALUE may name a file
} cli_takes;
typedef struct cli_option {
    const char *name; // long name without dashes at its front; in recipes the key, with '_' for '-'
    char letter;      // short name, 0: none
    cli_takes takes;
} cli_option;

// One pass over argv. Each call takes the next option or positional argument.
typedef struct cli_args {
    int argc, at;
    char **argv;
    const cli_option *options;
    int noptions;
    bool job; // also the options of cli_job: those of the command are numbered from CLI_JOB_OPTIONS
    const char *command;
    bool only_positionals; // after "--"
} cli_args;

enum { CLI_END = -1, CLI_POSITIONAL = -2, CLI_BAD = -3 };
// The index of the option read, or one of the above; *value is its value or the positional argument. On CLI_BAD a
// message with the nearest known option has been printed.
int cli_next(cli_args *args, const char **value);

// Numbers from text, or fractions of two (1/3); false after printing "--name: expected ..., got ...".
bool cli_double(const char *name, const char *text, double *out);
bool cli_int(const char *name, const char *text, int lo, int hi, int *out);
// "A" or "A,B" or up to `most` numbers; the number read, 0 after printing why not.
int cli_list(const char *name, const char *text, double *out, int most);
// "A" (both) or "A,B".
bool cli_int_pair(const char *name, const char *text, int lo, int hi, int out[2]);
bool cli_double_pair(const char *name, const char *text, double out[2]);
// The candidate nearest to word in edit distance when it is plausibly meant, else NULL.
const char *cli_nearest(const char *word, const char *const *candidates, int n);
// path ends in .ending, letters of either case.
bool cli_has_ending(const char *path, const char *ending);

// ---- messages, on stderr ----
void cli_error(const char *format, ...) KN_PRINTF(1, 2);
void cli_usage_hint(const char *command);

// A JSON string, which holds UTF-8 alone: of a text that is not, each byte beyond ASCII becomes a '?'.
struct json_t *cli_json_text(const char *text);

// Numbers of reports. JSON knows no infinity: null.
enum { CLI_JSON_DIGITS = 6, CLI_TEXT_DIGITS = 2 };
struct json_t *cli_json_number(double x);
// x moved up (sign 1) or down (-1) to a number of so many digits: what is printed of a bound is a bound, too.
double cli_outward(double x, int sign, int digits);
struct json_t *cli_json_upper(double x);
struct json_t *cli_json_lower(double x);

// ---- help ----
int cli_help(FILE *to, const char *command); // NULL: the overview. EXIT_USAGE for an unknown command.

// ---- session ----
typedef struct cli_session cli_session;
typedef struct cli_session_options {
    int threads;
    bool quiet;
} cli_session_options;
// NULL after printing why. Installs the handlers that turn Ctrl-C and termination into a cancelled job.
cli_session *cli_session_begin(cli_session_options options);
void cli_session_end(cli_session *session);
kn_ctx *cli_ctx(cli_session *session);
// Prints the context's error and answers the exit code that belongs to it. reading: a file was being read.
int cli_fail(cli_session *session, kn_status status, bool reading);
// The same for work on what was read from path: the message names it where what is in it is to blame.
int cli_fail_on(cli_session *session, kn_status status, const char *path, bool reading);
// The same with a message of its own.
int cli_fail_at(cli_session *session, kn_status status, const char *format, ...) KN_PRINTF(3, 4);
// A warning on standard error, unless the session is quiet.
void cli_warn(cli_session *session, const char *format, ...) KN_PRINTF(2, 3);
double cli_seconds(void); // a monotonic clock

// ---- programs that knurl runs ----
enum { CLI_PATH_BYTES = 4096 };
// What the environment's variable names; else the file of that name beside knurl, or in libexec beside the folder that
// knurl lies in; else the name alone, for the shell's way.
void cli_find_program(char out[CLI_PATH_BYTES], const char *name, const char *variable);

// ---- inputs ----
// All surfaces (two variables, three dimensions) of a spline file, and volumes if wanted, moved out of the model;
// others are left out.
typedef struct cli_base {
    kn_spline *surfaces;
    int nsurfaces;
    const char *path;
    kn_cad cad;           // of a CAD file; else empty
    int *face, *body;     // of the model, that each surface is, and of which body
    kn_trim *trims;       // of the surfaces, empty where a face is whole; NULL: all are
    kn_cad_joined joined; // what became of the edges between several faces; its surfaces are the base's
} cli_base;
int cli_read_base(cli_session *session, cli_base *out, const char *path, bool volumes); // exit code
void cli_base_clear(cli_session *session, cli_base *base);
// STEP, IGES and BREP, by the ending.
bool cli_is_cad(const char *path);
// Runs knurl-cad with arguments[0 ..] up to NULL; what it writes on standard output goes to *data, for kn_free, its
// warnings to the log, and what it says of a failure becomes the message. path: the file that it reads. input: what it
// finds on standard input; NULL: what knurl does.
kn_status cli_run_cad(kn_ctx *ctx, unsigned char **data, size_t *bytes, const char *const *arguments,
                      const char *path, FILE *input);
kn_status cli_read_cad(kn_ctx *ctx, kn_cad *out, const char *path);
// kn_read_model, and of CAD files the surfaces of all faces, whole.
kn_status cli_read_model(kn_ctx *ctx, kn_model *out, const char *path);
struct cli_job;
// Faces that meet smoothly become one domain, as the jobs' options ask; where some stay apart and --trimmed is not
// given, heights fall off to nothing there.
kn_status cli_join_faces(kn_ctx *ctx, struct cli_job *jobs, int njobs, cli_base *base);
struct json_t *cli_joined_json(const kn_cad_joined *joined); // NULL: of no edge
void cli_print_joined(const kn_cad_joined *joined);
// A built-in tile by name, or a tile from a file; cell: u0, v0, u1, v1 or NULL.
int cli_read_tile(cli_session *session, kn_tile *out, const char *name, const double *cell);
// A mesh by its ending: .obj .stl .ply .off .3mf .glb .gltf.
bool cli_is_mesh(const char *path);
kn_status cli_read_mesh(kn_ctx *ctx, kn_mesh *out, const char *path);
// The file's name without its folder and ending, cut to what fits.
void cli_name_of(char name[KN_NAME_BYTES], const char *path);
// The tile of a job, and what its description says of counts and heights where the job does not.
struct cli_job;
int cli_read_job_tile(cli_session *session, kn_tile *out, struct cli_job *job);

// ---- a texture on a base: what apply, check and slice share ----
struct cli_job;
typedef enum cli_place {
    CLI_OF_LAYER,  // a key of a layer, too
    CLI_OF_RECIPE, // a key of the recipe
    CLI_OF_RUN,    // an option alone
} cli_place;
// Options that belong together: cli/texture.c, placement.c, selection.c, view.c, variation.c, color.c, exactness.c,
// running.c.
typedef struct cli_theme {
    const cli_option *options;
    int noptions;
    cli_place place;
    // name is what messages call it: "--size" or the key of a recipe. The text is kept, not copied. False after a
    // message.
    bool (*set)(struct cli_job *job, const char *name, int option, const char *text);
} cli_theme;
enum { CLI_THEMES = 9, CLI_THEME_OPTIONS = 64, CLI_JOB_OPTIONS = CLI_THEMES * CLI_THEME_OPTIONS };
extern const cli_theme cli_texture_options, cli_placement_options, cli_selection_options, cli_view_options,
    cli_variation_options, cli_color_options, cli_exactness_options, cli_body_options, cli_running_options;
const cli_theme *cli_theme_of(int theme);

// A length that may name its unit: 3mm.
typedef struct cli_length {
    double value;
    double unit_mm; // 0: the base's
} cli_length;
// A number or vector for the whole base, or a spline from a file.
typedef enum cli_field_kind {
    CLI_FIELD_DIRECTION,
    CLI_FIELD_THICKNESS,
    CLI_FIELD_ATTRACTION,
    CLI_FIELDS
} cli_field_kind;
typedef struct cli_field {
    const char *path; // NULL: constant
    double value[3];
    bool given;
    kn_spline spline; // over [0,1]^2, once cli_job_begin has made it
} cli_field;
// What becomes of the body of a CAD base in STEP files (cli/body.h).
typedef enum cli_body_mode { CLI_BODY_DEFAULT, CLI_BODY_REPLACE, CLI_BODY_COVER, CLI_BODY_NONE } cli_body_mode;
// A number at every place of the base: a number, an expression, a picture or a spline from a file.
typedef struct cli_scalar {
    const char *text; // NULL: none
    kn_field field;   // once cli_scalar_begin has made it; borrows what follows
    double constant;
    kn_spline spline;
    kn_field_samples samples; // its values are the scalar's own
    struct kn_expression *expression;
} cli_scalar;

enum {
    CLI_MAX_COUNT = 65536, // cells along a surface: what a job takes
    CLI_MAX_FACES = 1024,
    CLI_MAX_FACE_TEXTS = 16,
    CLI_MAX_VARY = 32,
    CLI_MAX_PALETTE = 32,
    CLI_MAX_COLORED = 16,
};
typedef struct cli_vary {
    char parameter[KN_NAME_BYTES];
    cli_scalar value;
} cli_vary;
// Colours by a field, of some parts or of all.
typedef struct cli_color {
    cli_scalar field;
    double palette[CLI_MAX_PALETTE][3]; // linear RGB
    int npalette, steps;
    char part[CLI_MAX_COLORED][KN_NAME_BYTES];
    int nparts;                         // 0: all
    kn_job_color rule[CLI_MAX_COLORED]; // once cli_color_begin has made them
    int nrules;
} cli_color;
typedef struct cli_job {
    const char *base, *tile, *morph; // tile, morph NULL: none
    double unit_mm;
    kn_step_schema step; // of STEP files
    double cell[4];
    cli_length size[2], height, offset, mesh_tol, cells_tol, crossing_tol, scatter, taper, slab[2];
    kn_job_options options; // lengths and fields once cli_job_begin has filled them in
    cli_field field[CLI_FIELDS];
    cli_scalar mask;
    cli_vary vary[CLI_MAX_VARY];
    kn_job_vary varied[CLI_MAX_VARY];
    cli_color color;
    kn_job_view view;
    double camera[7];           // eye, what it looks at, degrees
    uint64_t given[CLI_THEMES]; // bit i of theme t: its option i was given
    int faces[CLI_MAX_FACES], nfaces, nvary;
    const char *face_text[CLI_MAX_FACE_TEXTS]; // that a CAD file is to be asked for
    int *chosen, nface_texts;                  // chosen: surfaces, once cli_choose_faces has found them
    int max_degree;                            // of faces in CAD files; 0: 25
    double seam_angle;                         // of faces of limited degree in CAD files, degrees; 0: the default
    bool instances;                            // in STEP files: cells that are equal once
    bool merge;                                // faces of several patches in CAD files
    int on;                                    // the layer that is its base, counted from 1; 0: the recipe's base
    int threads;
    bool has_cell, has_size, has_camera;
    cli_body_mode body;
    struct cli_face_colors *face_colors; // of the base, where the tile has none; NULL: none
    double join_angle;                   // degrees; 0: the default
    bool no_join;
    const kn_cad_joined *joined; // the base's; NULL: it is one face, or no CAD file
    bool base_only;              // it is not written itself
    bool json, quiet;
    bool recipe_cells;        // count or size came from a recipe: an option replaces them
    bool recipe_faces;        // likewise
    char name[KN_NAME_BYTES]; // of the layer, in a recipe
} cli_job;

cli_job cli_job_defaults(void);
// One option of the themes, as cli_next numbers them; false after a message.
bool cli_job_set(cli_job *job, int option, const char *value);
// The same under the name of a key, where messages say `name`.
bool cli_job_set_key(cli_job *job, int option, const char *name, const char *value);
// The number of the option whose key this is, in a layer or in a recipe itself; -1: none. *option: NULL not wanted.
int cli_job_find_key(const char *key, cli_place place, const cli_option **option);
bool cli_job_was_given(const cli_job *job, int option);
// Lengths in the base's unit, and fields read from their files, into job->options; exit code. The job stays where it
// is until cli_job_end.
int cli_job_begin(cli_session *session, cli_job *job);
void cli_job_end(cli_session *session, cli_job *job);
// Of a CAD file the faces that the jobs' --faces name: others leave the base, and those of each job go, with the base's
// trims, into its options. After cli_job_begin. Exit code.
int cli_choose_faces(cli_session *session, cli_job *jobs, int njobs, cli_base *base);
int cli_read_field(cli_session *session, cli_field *field, cli_field_kind kind); // exit code
// A surface of one component (or three, of which the last one counts) over [0,1]^2. Exit code.
int cli_read_scalar_spline(cli_session *session, kn_spline *out, const char *path, const char *name);
// The scalar's field from its text; name: of the option; seed: of noise. Exit code.
int cli_scalar_begin(cli_session *session, cli_scalar *scalar, const char *name, uint64_t seed);
void cli_scalar_end(cli_session *session, cli_scalar *scalar);
// Whether text names a file that can be a scalar.
bool cli_scalar_is_file(const char *text);
double cli_linear_of_srgb(double x);
// A palette, steps or parts, and no field.
bool cli_color_lacks_field(const cli_color *color);
int cli_color_begin(cli_session *session, cli_color *color, uint64_t seed); // the rules; exit code
// Parts of the tile that nobody gave a colour have that of the base's faces, one or a rule for several. After
// cli_choose_faces; until cli_job_end.
kn_status cli_take_face_colors(kn_ctx *ctx, cli_job *job, kn_tile *tile, const cli_base *base);
void cli_face_colors_free(kn_ctx *ctx, struct cli_face_colors *colors); // NULL is fine
// job->view from the camera.
void cli_make_view(cli_job *job);
// The angle above which an edge inside a base is a crease: what a job takes (0: the default tolerance of normals).
double cli_crease_angle(double normal_tol);
// Options that exclude or need each other; NULL, or what is wrong.
const char *cli_job_conflict(const cli_job *job);
// "--thickness FILE: " where a message is about a field from a file, else "".
typedef struct cli_field_text {
    char text[512];
} cli_field_text;
cli_field_text cli_blamed_field(const cli_job *job, const char *message);
// cli_fail_on for work on the job's base; the message names the file of a field that is to blame, and of a CAD file the
// face.
int cli_fail_on_job(cli_session *session, kn_status status, const cli_job *job, const cli_base *base);
// A field that is no file: false after a message when no texture can have it.
bool cli_field_makes_sense(const char *name, cli_field_kind kind, const cli_field *field);
// The heights from the base to the job's height on its side, lifted by the offset: lo <= hi.
void cli_job_range(const cli_job *job, double range[2]);

// Values of options; each prints its own message.
// The place of text among n names, or -1 after a message.
int cli_choice(const char *name, const char *text, const char *const *names, int n, const char *expected);
bool cli_set_unit(const char *name, const char *text, double *unit_mm);
bool cli_set_cell(const char *name, const char *text, double cell[4]);
// A number from 3 on, or a receiver's name; KN_MAX_DEGREE: exact, nothing is above it.
bool cli_set_max_degree(const char *name, const char *text, int *degree);
// The limits of CAD files: the degree, or 25, and --tol, or 0.01 mm, in the base's unit.
kn_limit_options cli_limits_of(const cli_job *job);
bool cli_length_of(const char *name, const char *text, cli_length *out);
bool cli_positive_length(const char *name, const char *text, cli_length *out);
// "A" for both, or "A,B".
bool cli_length_pair(const char *name, const char *text, cli_length out[2]);
// "A" and 0, or "A,B".
bool cli_shift_pair(const char *name, const char *text, double out[2]);
bool cli_above_zero(const char *name, double value);
const char *cli_unit_name(double unit_mm); // "mm" ..

// ---- recipes: layers of textures, and where they go ----
enum { CLI_MAX_LAYERS = 16, CLI_MAX_OUTPUTS = 16 };
// What a recipe says, or options in its place. Begin with cli_recipe_begin; cli_recipe_end frees texts alone.
typedef struct cli_recipe {
    cli_job layer[CLI_MAX_LAYERS]; // what they share (base, unit, threads ..) is the same in all
    int nlayers;                   // 1 or more
    const char *outputs[CLI_MAX_OUTPUTS];
    int noutputs;
    struct cli_owned *owned; // texts that the file gave
} cli_recipe;
void cli_recipe_begin(cli_recipe *recipe);
void cli_recipe_end(cli_recipe *recipe);
// One option of the themes, for all layers.
bool cli_recipe_set(cli_recipe *recipe, int option, const char *value);
// A spline file that is the base, or a recipe (.json) that names one. Exit code.
int cli_recipe_base(cli_recipe *recipe, const char *path);
// Fills the recipe from a file; exit code.
int cli_read_recipe(cli_recipe *recipe, const char *path);
bool cli_add_output(cli_recipe *recipe, const char *name, const char *path);
// One more output, of `most` at most; false after a message, which begins with name: there is no room, or that file is
// an output already, maybe by another name.
bool cli_take_output(const char *name, const char **outputs, int *n, int most, const char *path);
// cli_job_conflict of all layers.
const char *cli_recipe_conflict(const cli_recipe *recipe);

// The base and the tiles of a recipe. Zero is empty; cli_inputs_end ends it, and the jobs of the layers.
typedef struct cli_inputs {
    cli_base base;
    kn_tile tile[CLI_MAX_LAYERS];
} cli_inputs;
// Reads them and makes each layer's job->options ready (cli_job_begin). Exit code. The recipe stays where it is until
// cli_inputs_end.
int cli_inputs_begin(cli_session *session, cli_inputs *inputs, cli_recipe *recipe);
void cli_inputs_end(cli_session *session, cli_inputs *inputs, cli_recipe *recipe);

// ---- animate ----
// out, by ffmpeg, from the pictures beside it: STEM-0001.png .. of STEM.mp4. Exit code; out is whole, or unchanged.
int cli_make_video(cli_session *session, const char *out, double frames_per_second);

// ---- apply ----
typedef struct cli_apply {
    cli_recipe recipe;
    bool dry_run, resume, obj_surfaces;
} cli_apply;

// A sink for path by its ending. False (nothing printed) when the ending has no writer.
bool cli_can_write(const char *path);
typedef struct cli_output_options {
    double unit_mm;
    const kn_step_host *host; // of STEP files; NULL: none
    kn_step_schema schema;    // of STEP files
    double gap_mm;            // between the host's edges and those of the texture
    bool instances;           // of STEP files: an assembly
    bool obj_surfaces;        // curves and surfaces in .obj files instead of triangles
    const cli_base *base;     // whose faces give their names to those of STEP files; NULL: none
    const kn_cad *cad; // whose faces these are: they and their bodies keep their names in STEP files; NULL: none
} cli_output_options;
kn_status cli_open_sink(kn_ctx *ctx, kn_sink *out, const char *path, const cli_output_options *options);
// A sink for Rhino's .3dm files: of curves and untrimmed surfaces, by node and its package rhino3dm, which hold the
// whole file in memory. fails: as kn_g2_sink; KN_ENOTBUILT where they are missing, or refuse.
kn_status cli_rhino_sink(kn_ctx *ctx, kn_sink *out, const char *path, double unit_mm);
bool cli_writes_cad(const char *path);  // of those that can be written
bool cli_holds_trims(const char *path); // trimmed surfaces as such, not as triangles
// The faces of a CAD file through sinks.
typedef struct cli_cad_options {
    bool trims; // faces are whole, else they come piece by piece
    bool edges; // faces share edges, curves of degree max_degree (0: any) in space and in the plane
    int max_degree;
    double mesh_tol; // chord height of triangles, 0: a thousandth of the size
} cli_cad_options;
kn_status cli_stream_cad(kn_ctx *ctx, const kn_cad *cad, const char *name, const cli_cad_options *options,
                         kn_sink *sinks, int nsinks);
// Segments of each span of each face in u and v, whose triangles are within tol > 0, about: kn_free. fails: KN_ENOMEM.
kn_status cli_cad_segments(kn_ctx *ctx, int (**out)[2], const kn_cad *cad, double tol);
// What is around a face: kn_free its edges.
kn_status cli_cad_bounds(kn_ctx *ctx, kn_patch_bounds *out, const kn_cad *cad, int face, int max_degree);
const char *cli_writable_endings(void);
// Bytes that a writer will need, estimated before anything is composed.
double cli_estimate_bytes(const char *path, const kn_job_report *report);

typedef struct cli_timing {
    double read, plan, run;
} cli_timing;
struct cli_plan;
struct cli_fit;
struct cli_body_run;
void cli_print_apply(const cli_apply *apply, const struct cli_plan *plan, const struct cli_fit *fit,
                     const struct cli_body_run *body, const double *bytes, const cli_timing *timing,
                     size_t peak_bytes);

// ---- info ----
// Creases, poles, apexes and places without a normal of a model's surfaces, as arrays in notes; and as lines of text.
kn_status cli_look_at_edges(kn_ctx *ctx, struct json_t *notes, const kn_model *model);
void cli_print_edges(const struct json_t *notes);
int cli_info_cad(cli_session *session, const char *file, bool json); // bodies, faces, edges. Exit code

// ---- tiles ----
// What is proved of a tile: its periodicity, and whether it covers. Exit code.
int cli_check_tile(cli_session *session, const kn_tile *tile, bool json);

// ---- commands: argv[0] is the command's name ----
int cli_command_apply(int argc, char **argv);
int cli_command_animate(int argc, char **argv);
int cli_command_tiles(int argc, char **argv);
int cli_command_info(int argc, char **argv);
int cli_command_eval(int argc, char **argv);
int cli_command_render(int argc, char **argv);
int cli_command_check(int argc, char **argv);
int cli_command_slice(int argc, char **argv);
int cli_command_convert(int argc, char **argv);

#endif
