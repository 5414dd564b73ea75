// SPDX-License-Identifier: Apache-2.0
// The shell of each surface of a job: degrees, the bounds of its Jacobian.
#include "job/internal.h"
#include "kernel/parallel.h"

#include <math.h>
#include <stdio.h>

static const int least_normal_degree = 3; // of n in each variable
static const int usual_normal_degree = 5; // and of m, where n = N m
static const int most_rounds = 4;         // of making shells again

// What the terms of T need, as sums of their degrees and the power of w: T's factor on the degree of a tile patch. Of
// n, which is yet to be made, the least; *room: what adds to it.
static int least_factor(int *room, const kn_job_base *b, const kn_spline *face, int power)
{
    int a = face->degree[0] + face->degree[1], most = a;
    int weight = face->rational ? a : 0; // fields are multiplied by it
    int h = b->thickness.coef ? b->thickness.degree[0] + b->thickness.degree[1] : 0;
    *room = 0;
    if (b->volume.coef) return a + b->volume.degree[2];
    if (b->attraction.coef) {
        int psi = b->attraction.degree[0] + b->attraction.degree[1] + weight + power;
        most = psi > most ? psi : most;
    }
    int n = b->direction.coef ? b->direction.degree[0] + b->direction.degree[1] : 2 * least_normal_degree;
    *room = h + weight + 1;
    return n + *room > most ? n + *room : most;
}

// What helps, beside a limit above what other programs read.
static kn_status no_room(kn_ctx *ctx, const kn_job *job, const kn_job_base *b, const kn_spline *face, int tile,
                         int factor, int origin)
{
    int limit = job->options.max_degree, need = tile * factor, fits = limit / factor;
    char other[48] = "";
    if (fits > 0) (void)snprintf(other, sizeof other, ", or a tile of degree %d at most", fits);
    const char *field = job->options.stretch ? ", or no stretch"
                        : b->thickness.coef  ? ", or a thickness of lower degree"
                                             : "";
    const char *much = need > KN_MAX_DEGREE ? ", which is more than there is"
                       : need > 25          ? ", which readers of STEP may refuse"
                                            : "";
    return kn_fail(ctx, KN_EDOMAIN,
                   "job: tile patches of degree %d over surface %d of degrees %d, %d compose to degree %d or more, "
                   "and the limit is %d: --max-degree %d is needed%s%s%s",
                   tile, origin, face->degree[0], face->degree[1], need, limit, need, much, other, field);
}

// A tile patch of degree m composes to degree m times the largest sum of a term's degrees and its power of w: those of
// S, of h n and 1, of psi and k; where S is rational those of the weight come to the fields.
static kn_status fit_degrees(kn_ctx *ctx, kn_job *job, const kn_job_bases *bases)
{
    int tile = kn_job_tile_degree(job), limit = job->options.max_degree;
    int power = job->options.attraction_power > 0 ? job->options.attraction_power : 2;
    for (int s = 0; s < job->nsurfaces; s++) {
        const kn_spline *face = &bases->faces[s];
        int room, least = least_factor(&room, &bases->list[s], face, power);
        if (tile * least > limit)
            return no_room(ctx, job, &bases->list[s], face, tile, least, job->surfaces[s].origin);
        job->surfaces[s].degree_sum = limit / tile - room;
        job->surfaces[s].tile_degree = tile;
    }
    return KN_OK;
}

typedef struct shells {
    kn_job *job;
    const kn_job_bases *bases;
    double w[2];           // the heights that the tile occupies
    bool touches;          // it reaches the border of its cell: tiles side by side join there
    kn_job_evened *evened; // which are made again, and how; NULL: all are, for the first time
} shells;

// The degree of n in each variable, or of m: what there is room for, up to the usual one.
static int normal_degree(const kn_job *job, const kn_job_surface *to, const kn_spline *face)
{
    int room = to->degree_sum;
    if (job->options.normal == KN_NORMAL_EXACT_DIRECTION) // N has less at a pole
        for (int v = 0; v < 2; v++) room -= (face->rational ? 3 : 2) * face->degree[v] - 1;
    int degree = room / 2 < usual_normal_degree ? room / 2 : usual_normal_degree;
    return degree > least_normal_degree ? degree : least_normal_degree;
}

// An exact direction may have a higher degree than there is room for.
static kn_status check_normal(kn_ctx *ctx, const kn_job *job, const kn_job_surface *s)
{
    const kn_spline *n = kn_shell_normal(s->shell);
    int degree = n->coef ? n->degree[0] + n->degree[1] : 0, room = job->options.max_degree / s->tile_degree;
    if (job->options.normal != KN_NORMAL_EXACT_DIRECTION || degree <= s->degree_sum) return KN_OK;
    int need = s->tile_degree * (degree + room - s->degree_sum);
    return kn_fail(
        ctx, KN_EDOMAIN,
        "job: with a normal of exact direction, of degrees %d, %d, over surface %d tile patches of degree %d "
        "compose to degree %d, and the limit is %d: --max-degree %d is needed%s",
        n->degree[0], n->degree[1], s->origin, s->tile_degree, need, job->options.max_degree, need,
        need > KN_MAX_DEGREE ? ", which is more than there is" : "");
}

static const kn_spline *given(const kn_spline *s)
{
    return s->coef ? s : NULL;
}

// A shell does not know which surface it is of.
static kn_status name_surface(kn_ctx *ctx, kn_status status, int origin)
{
    char message[400];
    (void)snprintf(message, sizeof message, "%s", kn_ctx_message(ctx));
    if (message[0] == 0 || status == KN_ENOMEM || status == KN_ECANCELLED) return status;
    kn_ctx_clear_error(ctx);
    return kn_fail(ctx, status, "job: surface %d: %s", origin, message);
}

// The shell of another degree, where there is room for it; else the first one stays, and what it shares is less.
static kn_status replace_shell(kn_ctx *ctx, kn_job_surface *to, kn_shell *made, kn_status status)
{
    if (status == KN_ENOMEM || status == KN_ECANCELLED) return status;
    kn_ctx_clear_error(ctx);
    const kn_spline *n = made ? kn_shell_normal(made) : NULL;
    if (!n || n->degree[0] + n->degree[1] > to->degree_sum) {
        kn_shell_destroy(ctx, made);
        return KN_OK;
    }
    kn_shell_destroy(ctx, to->shell);
    to->shell = made;
    kn_shell_closed(to->shell, to->closed);
    return KN_OK;
}

static kn_status make_shell(kn_ctx *ctx, void *user, size_t index)
{
    const shells *all = user;
    const kn_job_base *base = &all->bases->list[index];
    const kn_job_options *options = &all->job->options;
    kn_job_surface *to = &all->job->surfaces[index];
    kn_shell_options o = kn_shell_defaults();
    if (all->evened && !all->evened[index].again) return KN_OK;
    for (int d = 0; d < 2; d++) {
        o.min_degree[d] = all->evened ? all->evened[index].least[d] : 0;
        o.cells_apart[d] = all->evened && all->evened[index].apart[d];
        o.lines[d] = to->lines[d];
        o.nlines[d] = to->cells[d] + 1;
    }
    o.normal_tol = options->normal_tol;
    o.normal = options->normal;
    o.direction = given(&base->direction), o.thickness = given(&base->thickness);
    o.attraction = given(&base->attraction), o.attraction_power = options->attraction_power;
    if (!o.direction && !base->volume.coef) o.max_degree = normal_degree(all->job, to, &all->bases->faces[index]);
    if (all->touches) o.cell_degree_sum = to->degree_sum;
    kn_shell *made = NULL;
    kn_status status = base->volume.coef ? kn_shell_from_volume(ctx, &made, &base->volume, &o)
                                         : kn_shell_create(ctx, &made, &all->bases->faces[index], &o);
    if (all->evened) return replace_shell(ctx, to, made, status);
    to->shell = made;
    if (status == KN_OK && !o.direction) status = check_normal(ctx, all->job, to);
    if (status != KN_OK) return to->shell ? status : name_surface(ctx, status, to->origin);

    kn_shell_closed(to->shell, to->closed);
    return kn_shell_jacobian_bounds(ctx, &to->jacobian[0], &to->jacobian[1], to->shell, all->w[0], all->w[1]);
}

// Shells of surfaces that go on over shared edges, made again where n is not of one degree along these: what one has
// to be others may have to be too, and the next round tells.
static kn_status make_even(kn_ctx *ctx, shells *all)
{
    size_t n = (size_t)all->job->nsurfaces;
    kn_job_evened *evened = all->evened = kn_alloc_zero(ctx, n, sizeof *evened);
    kn_status status = evened ? KN_OK : KN_ENOMEM;
    bool again = true;
    for (int round = 0; status == KN_OK && again && round < most_rounds; round++) {
        for (size_t i = 0; i < n; i++) evened[i].again = false;
        status = kn_job_even_degrees(ctx, evened, &again, all->job);
        if (status == KN_OK && again) status = kn_parallel(ctx, n, make_shell, all, "shell");
        if (status == KN_OK && again) status = kn_job_match_edges(ctx, all->job, all->w);
    }
    kn_free(ctx, evened);
    all->evened = NULL;
    if (status == KN_OK) status = kn_job_share_edges(ctx, all->job);
    return status == KN_OK ? kn_job_find_meeting(ctx, all->job) : status;
}

// Whether tiles may go on over an edge at which w turns over.
static bool turns_over(const kn_job *job)
{
    for (int s = 0; s < job->nsurfaces; s++)
        for (int e = 0; e < 4; e++)
            if (kn_job_turns_over(e, &job->surfaces[s].partner[e])) return true;
    return false;
}

kn_status kn_job_make_shells(kn_ctx *ctx, kn_job *job, const kn_job_bases *bases)
{
    shells all = {job, bases, {INFINITY, -INFINITY}, false, NULL};
    for (int k = 0; k < job->npatches; k++) {
        size_t n = kn_bezier_count(&job->patches[k].d);
        const double *u = job->patches[k].d.coef, *w = u + 2 * n;
        for (size_t i = 0; i < 2 * n; i++) all.touches = all.touches || u[i] <= 0.0 || u[i] >= 1.0;
        for (size_t i = 0; i < n; i++) {
            all.w[0] = fmin(all.w[0], w[i]);
            all.w[1] = fmax(all.w[1], w[i]);
        }
    }
    for (int p = 0; p < job->tile.nparts; p++) {
        const kn_mesh *mesh = &job->tile.parts[p].mesh;
        for (size_t i = 0; i < mesh->nvertices; i++) {
            double w = kn_job_place_w(&job->options, mesh->position[3 * i + 2]);
            all.w[0] = fmin(all.w[0], w);
            all.w[1] = fmax(all.w[1], w);
        }
    }
    if (turns_over(job)) {
        double top = fmax(fabs(all.w[0]), fabs(all.w[1]));
        all.w[0] = -top, all.w[1] = top;
    }
    kn_status status = fit_degrees(ctx, job, bases);
    if (status == KN_OK) status = kn_parallel(ctx, (size_t)job->nsurfaces, make_shell, &all, "shell");
    for (int s = 0; s < job->nsurfaces; s++) // nobody lends yet
        for (int k = 0; k < 4; k++) job->surfaces[s].corner[k] = -1;
    if (status == KN_OK) status = kn_job_match_edges(ctx, job, all.w);
    if (status == KN_OK && all.touches) status = make_even(ctx, &all);
    job->report.jacobian_lo = INFINITY;
    job->report.jacobian_hi = -INFINITY;
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++) {
        job->report.jacobian_lo = fmin(job->report.jacobian_lo, job->surfaces[s].jacobian[0]);
        job->report.jacobian_hi = fmax(job->report.jacobian_hi, job->surfaces[s].jacobian[1]);
    }
    return status;
}
