// SPDX-License-Identifier: Apache-2.0
// Options of view: only what a camera sees, as finely as it sees it.
#include "cli/cli.h"

#include <math.h>
#include <string.h>

enum { CAMERA, PICTURE, LEAST_PIXELS, HIDDEN, OPTIONS };
static const cli_option options[OPTIONS] = {
    [CAMERA] = {"camera", 0, CLI_TEXT},
    [PICTURE] = {"picture", 0, CLI_TEXT},
    [LEAST_PIXELS] = {"least-pixels", 0, CLI_TEXT},
    [HIDDEN] = {"hidden", 0, CLI_NOTHING},
};

static bool set_camera(cli_job *job, const char *name, const char *text)
{
    double x[7] = {[6] = 40}, length = 0;
    int n = cli_list(name, text, x, 7);
    for (int c = 0; c < 3; c++) length += (x[3 + c] - x[c]) * (x[3 + c] - x[c]);
    if (n >= 6 && length > 0 && isfinite(length) && x[6] > 0 && x[6] < 180) {
        memcpy(job->camera, x, sizeof x);
        return job->has_camera = true;
    }
    if (n > 0)
        cli_error("%s: expected X,Y,Z of the eye, X,Y,Z of what it looks at, and perhaps degrees of the picture's "
                  "height, got '%s'",
                  name, text);
    return false;
}

static bool set(cli_job *job, const char *name, int option, const char *text)
{
    switch (option) {
    case CAMERA: return set_camera(job, name, text);
    case PICTURE: return cli_int_pair(name, text, 1, 65536, job->view.pixels);
    case LEAST_PIXELS:
        return cli_double(name, text, &job->view.least_pixels) && cli_above_zero(name, job->view.least_pixels);
    case HIDDEN: return job->view.hidden = true;
    default: return false;
    }
}

const cli_theme cli_view_options = {options, OPTIONS, CLI_OF_LAYER, set};

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double *out, const double *a, const double *b)
{
    for (int c = 0; c < 3; c++) out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

static void normalize(double *a)
{
    double length = sqrt(dot(a, a));
    for (int c = 0; c < 3; c++) a[c] /= length;
}

// Rows of the matrix: right / (tan aspect), up / tan, 0 (nothing is too near or too far), forward.
void cli_make_view(cli_job *job)
{
    const double *eye = job->camera, *at = eye + 3;
    double forward[3], right[3], up[3] = {0, 0, 1}, half = tan(job->camera[6] * (acos(-1.0) / 360.0));
    for (int c = 0; c < 3; c++) forward[c] = at[c] - eye[c];
    normalize(forward);
    if (fabs(forward[2]) > 0.999) up[1] = 1, up[2] = 0; // straight down: y is up
    cross(right, forward, up);
    normalize(right);
    cross(up, right, forward);
    if (job->view.pixels[0] == 0) job->view.pixels[0] = 1600, job->view.pixels[1] = 1200;
    double aspect = (double)job->view.pixels[0] / job->view.pixels[1];
    for (int c = 0; c < 3; c++) {
        job->view.matrix[c] = right[c] / (half * aspect);
        job->view.matrix[4 + c] = up[c] / half;
        job->view.matrix[12 + c] = forward[c];
    }
    for (int row = 0; row < 4; row++) job->view.matrix[4 * row + 3] = -dot(job->view.matrix + 4 * row, eye);
}
