// SPDX-License-Identifier: Apache-2.0
// The degrees in which tile patches compose: those of u, v and w by themselves.
//
// Where u runs along r alone and v along t alone, a term of degrees (a,b) and power k composes to degree
// a u_r + b v_r + k w_r in r, far less than (a + b + k) times the patch's degree. Patches side by side need one
// degree along their common edge: so u_r and the others are the largest of all patches that hang together by opposite
// edges and common ones.
#include "job/internal.h"
#include "job/vary.h"
#include "kernel/union_find.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double rounding = 0x1p-48; // of a cell; of w of its size, as kn_compose_matrix_init has it

// ---- of one patch ----

static void raise_to(int *to, int degree)
{
    if (degree > *to) *to = degree;
}

static double height_of(const kn_bezier *d)
{
    double most = 0.0;
    size_t n = kn_bezier_count(d);
    for (size_t i = 2 * n; i < 3 * n; i++) most = fmax(most, fabs(d->coef[i]));
    return most;
}

// Raises the degrees to those of the components of d, where heights are up to `height`.
static kn_status take_patch(kn_ctx *ctx, kn_job_least *least, const kn_bezier *d, double height)
{
    kn_status status = KN_OK;
    for (int c = 0; c < 3 && status == KN_OK; c++) {
        kn_bezier x = {0};
        int degree[KN_MAX_VARS];
        double size = c < 2 ? 1.0 : height;
        status = kn_bezier_components(ctx, &x, d, c, 1);
        for (size_t i = 0; status == KN_OK && i < kn_bezier_count(&x); i++) size = fmax(size, fabs(x.coef[i]));
        if (status == KN_OK) status = kn_bezier_least_degree(ctx, degree, &x, rounding * size);
        for (int v = 0; v < d->nvars && status == KN_OK; v++) raise_to(&least->degree[c][v], degree[v]);
        kn_bezier_clear(ctx, &x);
    }
    return status;
}

// Component c of each control point of d goes its own way.
static void take_all(kn_job_least *least, const kn_bezier *d, int c)
{
    for (int v = 0; v < d->nvars; v++) raise_to(&least->degree[c][v], d->degree[v]);
}

// ---- what moves with parameters ----

static bool is_varied(const kn_job *job, kn_job_effect effect, int parameter)
{
    for (int r = 0; job->varying && r < job->varying->nrules; r++) {
        const kn_job_rule *rule = &job->varying->rules[r];
        if (rule->effect == effect && rule->parameter == parameter) return true;
    }
    return false;
}

// Of a spline's patches and the way to one of their targets. A field moves each control point by another amount.
static kn_status take_moves(kn_ctx *ctx, kn_job_least *least, const kn_spline *rest, const kn_spline *target,
                            bool varied)
{
    kn_bezier *from = NULL, *to = NULL;
    size_t nfrom = 0, nto = 0;
    kn_status status = kn_spline_to_bezier(ctx, &from, &nfrom, rest);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &to, &nto, target);
    for (size_t i = 0; status == KN_OK && i < nfrom && i < nto; i++) {
        size_t n = kn_bezier_count(&to[i]);
        double height = fmax(height_of(&from[i]), height_of(&to[i]));
        bool moves[3] = {false, false, false};
        for (size_t k = 0; k < 3 * n; k++) {
            to[i].coef[k] -= from[i].coef[k];
            moves[k / n] = moves[k / n] || to[i].coef[k] != 0.0;
        }
        for (int c = 0; c < 3; c++)
            if (varied && moves[c]) take_all(&least[i], &to[i], c);
        status = take_patch(ctx, &least[i], &to[i], height);
    }
    for (size_t i = 0; i < nfrom; i++) kn_bezier_clear(ctx, &from[i]);
    for (size_t i = 0; i < nto; i++) kn_bezier_clear(ctx, &to[i]);
    kn_free(ctx, from);
    kn_free(ctx, to);
    return status;
}

static kn_status take_parameters(kn_ctx *ctx, kn_job_least *least, const kn_job *job)
{
    kn_status status = KN_OK;
    for (int p = 0; p < job->tile.nparts; p++) {
        const kn_tile_part *part = &job->tile.parts[p];
        for (int s = 0; s < part->nsplines && status == KN_OK; s++) {
            for (int k = 0; k < job->tile.nparameters && part->targets && status == KN_OK; k++) {
                const kn_spline *target = &part->targets[k * part->nsplines + s];
                bool varied = is_varied(job, KN_EFFECT_PARAMETER, k);
                if (target->coef) status = take_moves(ctx, least, &part->splines[s], target, varied);
            }
            least += kn_job_bezier_patches(&part->splines[s]);
        }
    }
    return status;
}

// ---- edges ----

// An edge of a patch: its control points from the end that comes first. Edges in lines between cells are taken to the
// lower line, where those of the next cell are.
typedef struct edge {
    const kn_bezier *d;
    int place; // KN_JOB_VARS times the Bezier patch, + the variable along which it runs
    int count;
    ptrdiff_t first, step;
    bool in_line[2];
} edge;

static double number(const edge *e, int c, int i)
{
    if (c < 2 && e->in_line[c]) return 0.0;
    return e->d->coef[(ptrdiff_t)((size_t)c * kn_bezier_count(e->d)) + e->first + i * e->step];
}

static int compare_edges(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    if (x->count != y->count) return x->count - y->count;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < x->count; i++) {
            double p = number(x, c, i), q = number(y, c, i);
            if (p != q) return p < q ? -1 : 1;
        }
    return 0;
}

// The edge of a patch along var at these ends (bits) of the other variables.
static edge make_edge(const kn_job_patch *patch, int var, int ends)
{
    const kn_bezier *d = &patch->d;
    edge e = {.d = d, .place = KN_JOB_VARS * patch->bezier + var, .count = d->degree[var] + 1};
    ptrdiff_t stride = 1;
    for (int v = d->nvars - 1; v >= 0; stride *= d->degree[v--] + 1) {
        if (v == var) {
            e.step = stride;
            continue;
        }
        if (ends & 1) e.first += d->degree[v] * stride;
        ends >>= 1;
    }
    for (int c = 0; c < 2; c++) {
        bool one = true;
        for (int i = 0; i < e.count && one; i++) one = number(&e, c, i) == 1.0;
        e.in_line[c] = one; // that at 0 is where it is
    }
    edge back = e;
    back.first += (e.count - 1) * e.step;
    back.step = -e.step;
    return compare_edges(&back, &e) < 0 ? back : e;
}

// class_of[KN_JOB_VARS k + v], of variable v of Bezier patch k: what has to have the same degrees.
static kn_status find_classes(kn_ctx *ctx, int *class_of, const kn_job *job)
{
    size_t n = 0, most = 0;
    for (int k = 0; k < job->npatches; k++) most += (size_t)(job->patches[k].d.nvars << 2);
    edge *edges = kn_alloc(ctx, most + 1, sizeof *edges);
    if (!edges) return KN_ENOMEM;
    for (int k = 0; k < job->npatches; k++) {
        int nvars = job->patches[k].d.nvars;
        for (int v = 0; v < nvars; v++)
            for (int ends = 0; ends < 1 << (nvars - 1); ends++) edges[n++] = make_edge(&job->patches[k], v, ends);
    }
    qsort(edges, n, sizeof *edges, compare_edges);
    for (size_t i = 1; i < n; i++)
        if (compare_edges(&edges[i - 1], &edges[i]) == 0)
            kn_class_unite(class_of, edges[i - 1].place, edges[i].place);
    kn_free(ctx, edges);
    return KN_OK;
}

// Where tiles lie at an angle, or are turned over an edge of the base, u and v stand for one another.
static bool is_turned(const kn_job *job)
{
    bool turned = job->options.placement.angle != 0.0 || kn_job_has_chance(job);
    for (int i = 0; i < 4 * job->nsurfaces; i++) {
        const kn_job_partner *p = &job->surfaces[i / 4].partner[i % 4];
        turned = turned || (p->edge >= 0 && p->goes_on && (p->edge % 4 >> 1) != (i % 4 >> 1));
    }
    return turned;
}

// ---- the whole ----

static kn_status find_own(kn_ctx *ctx, kn_job_least *least, const kn_job *job)
{
    bool raised = job->options.taper > 0.0 || is_varied(job, KN_EFFECT_HEIGHT, -1) ||
                  is_varied(job, KN_EFFECT_OFFSET, -1);
    kn_status status = KN_OK;
    for (int k = 0; k < job->npatches && status == KN_OK; k++) {
        const kn_job_patch *p = &job->patches[k];
        status = take_patch(ctx, &least[p->bezier], &p->d, p->top);
        if (raised) take_all(&least[p->bezier], &p->d, 2);
    }
    return status == KN_OK ? take_parameters(ctx, least, job) : status;
}

// To the largest of each class; uv: of u and v together.
static void make_equal(kn_job_least *least, int n, int *class_of, bool uv)
{
    enum { VARS = KN_JOB_VARS };
    for (int i = 0; i < VARS * n; i++) {
        int root = kn_class_root(class_of, i);
        const kn_job_least *from = &least[i / VARS];
        kn_job_least *to = &least[root / VARS];
        for (int c = 0; c < 3; c++) raise_to(&to->degree[c][root % VARS], from->degree[c][i % VARS]);
        for (int c = 0; c < 2 && uv; c++) raise_to(&to->degree[c][root % VARS], from->degree[1 - c][i % VARS]);
    }
    for (int i = 0; i < VARS * n; i++) {
        int root = kn_class_root(class_of, i);
        for (int c = 0; c < 3; c++) least[i / VARS].degree[c][i % VARS] = least[root / VARS].degree[c][root % VARS];
    }
}

kn_status kn_job_find_least(kn_ctx *ctx, kn_job *job)
{
    if (job->options.symbolic || job->npatches == 0) return KN_OK; // symbolically, in the degrees of the patches
    int n = 1 + job->patches[job->npatches - 1].bezier;
    int *class_of = kn_alloc(ctx, KN_JOB_VARS * (size_t)n, sizeof *class_of);
    kn_job_least *least = kn_alloc_zero(ctx, (size_t)n, sizeof *least);
    kn_status status = class_of && least ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < KN_JOB_VARS * n && status == KN_OK; i++) class_of[i] = i;
    if (status == KN_OK) status = find_own(ctx, least, job);
    if (status == KN_OK) status = find_classes(ctx, class_of, job);
    if (status == KN_OK) make_equal(least, n, class_of, is_turned(job));
    kn_free(ctx, class_of);
    if (status == KN_OK)
        job->least = least;
    else
        kn_free(ctx, least);
    return status;
}

// ---- their use ----

void kn_job_least_degrees(int least[3][KN_JOB_VARS], const kn_job *job, const kn_job_patch *patch, bool whole)
{
    const kn_job_least *found = whole && job->least ? &job->least[patch->bezier] : NULL;
    for (int c = 0; c < 3; c++)
        for (int v = 0; v < KN_JOB_VARS; v++)
            least[c][v] = found ? found->degree[c][v] : v < patch->d.nvars ? patch->d.degree[v] : 0;
}

void kn_job_raise(int degree[KN_JOB_VARS], const int least[3][KN_JOB_VARS], const int term[2], int power)
{
    for (int v = 0; v < KN_JOB_VARS; v++)
        raise_to(&degree[v], term[0] * least[0][v] + term[1] * least[1][v] + power * least[2][v]);
}
