// SPDX-License-Identifier: Apache-2.0
// How many cells each surface gets: the same on edges that surfaces share.
#include "compose/job.h"

#include <math.h>

// Edges of surface s: 4s + 0 and 1 at the ends of u (they run along v), 4s + 2 and 3 at the ends of v.
typedef struct edge {
    double *point; // 3 n numbers, projected
    int n, degree;
    bool collapsed;
} edge;

static double separation(const double *p, const double *q)
{
    return fmax(fabs(p[0] - q[0]), fmax(fabs(p[1] - q[1]), fabs(p[2] - q[2])));
}

static kn_status edge_init(kn_ctx *ctx, edge *out, const kn_spline *s, int which, double tol)
{
    int fixed = which >> 1, along = 1 - fixed, n = s->count[along];
    size_t count = kn_spline_count(s), row = (size_t)s->count[1];
    size_t start = (which & 1) == 0 ? 0 : fixed == 0 ? count - row : row - 1, step = along == 0 ? row : 1;
    *out = (edge){.point = kn_alloc(ctx, 3 * (size_t)n, sizeof(double)), .n = n, .degree = s->degree[along]};
    if (!out->point) return KN_ENOMEM;
    out->collapsed = true;
    for (int i = 0; i < n; i++) {
        size_t at = start + (size_t)i * step;
        double w = s->rational ? s->coef[3 * count + at] : 1.0;
        for (size_t c = 0; c < 3; c++) out->point[3 * (size_t)i + c] = s->coef[c * count + at] / w;
        if (separation(out->point + 3 * i, out->point) > tol) out->collapsed = false;
    }
    return KN_OK;
}

static bool coincide(const edge *a, const edge *b, double tol)
{
    if (a->n != b->n || a->degree != b->degree || a->collapsed || b->collapsed) return false;
    bool forward = true, backward = true;
    for (int i = 0; (forward || backward) && i < a->n; i++) {
        forward = forward && separation(a->point + 3 * i, b->point + 3 * i) <= tol;
        backward = backward && separation(a->point + 3 * i, b->point + 3 * (b->n - 1 - i)) <= tol;
    }
    return forward || backward;
}

// ---- classes of edges that must have one count: a forest in which parent[root] = root ----
static int root_of(int *parent, int e)
{
    for (; parent[e] != e; e = parent[e]) parent[e] = parent[parent[e]];
    return e;
}

static void join(int *parent, int a, int b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static kn_status find_classes(kn_ctx *ctx, int *parent, const kn_spline *surfaces, int nsurfaces, double tol)
{
    int n = 4 * nsurfaces;
    edge *edges = kn_alloc_zero(ctx, (size_t)n, sizeof *edges);
    kn_status status = edges ? KN_OK : KN_ENOMEM;
    for (int e = 0; status == KN_OK && e < n; e++) {
        parent[e] = e;
        status = edge_init(ctx, &edges[e], &surfaces[e / 4], e % 4, tol);
    }
    for (int s = 0; status == KN_OK && s < nsurfaces; s++) {
        join(parent, 4 * s, 4 * s + 1);
        join(parent, 4 * s + 2, 4 * s + 3);
    }
    for (int e = 0; status == KN_OK && e < n; e++)
        for (int f = e + 1; f < n; f++)
            if (coincide(&edges[e], &edges[f], tol)) join(parent, e, f);
    for (int e = 0; edges && e < n; e++) kn_free(ctx, edges[e].point);
    kn_free(ctx, edges);
    return status;
}

typedef struct edge_class {
    double sum; // of length / size over isoparametric curves
    int curves, spans;
} edge_class;

// The count of each class: the mean of length / size over its curves, no fewer than any member has knot spans.
static kn_status count_by_size(kn_ctx *ctx, int (*counts)[2], const kn_spline *surfaces, int nsurfaces,
                               const kn_job_measure *measures, const double size[2], double tol)
{
    int *parent = kn_alloc(ctx, 4 * (size_t)nsurfaces, sizeof *parent);
    edge_class *classes = kn_alloc_zero(ctx, 4 * (size_t)nsurfaces, sizeof *classes);
    kn_status status = parent && classes ? find_classes(ctx, parent, surfaces, nsurfaces, tol) : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < nsurfaces; s++)
        for (int along = 0; along < 2; along++) {
            edge_class *c = &classes[root_of(parent, 4 * s + (along == 0 ? 2 : 0))];
            for (int k = 0; k < 3; k++) c->sum += measures[s].length[along][k] / size[along];
            int spans = kn_spline_spans(&surfaces[s], along);
            c->curves += 3;
            c->spans = spans > c->spans ? spans : c->spans;
        }
    for (int s = 0; status == KN_OK && s < nsurfaces; s++)
        for (int along = 0; status == KN_OK && along < 2; along++) {
            const edge_class *c = &classes[root_of(parent, 4 * s + (along == 0 ? 2 : 0))];
            double count = fmax(round(c->sum / c->curves), fmax(1.0, c->spans));
            if (!(count <= KN_JOB_MAX_COUNT))
                status = kn_fail(ctx, KN_ELIMIT, "job: %.0f cells of size %g along surface %d, at most %d", count,
                                 size[along], s, KN_JOB_MAX_COUNT);
            else
                counts[s][along] = (int)count;
        }
    kn_free(ctx, parent);
    kn_free(ctx, classes);
    return status;
}

static kn_status check_count(kn_ctx *ctx, const kn_spline *surface, int s, int along, int count)
{
    int spans = kn_spline_spans(surface, along);
    if (count > KN_JOB_MAX_COUNT)
        return kn_fail(ctx, KN_ELIMIT, "job: count %d, at most %d", count, KN_JOB_MAX_COUNT);
    if (count < spans)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: count %d in %s would make cells straddle knot lines of surface %d, which has %d knot "
                       "spans there: at least %d",
                       count, along == 0 ? "u" : "v", s, spans, spans);
    return KN_OK;
}

kn_status kn_job_counts(kn_ctx *ctx, int (*counts)[2], const kn_spline *surfaces, int nsurfaces,
                        const kn_job_measure *measures, const kn_job_options *options, double diagonal)
{
    kn_status status = KN_OK;
    if (options->count[0] == 0 || options->count[1] == 0)
        status = count_by_size(ctx, counts, surfaces, nsurfaces, measures, options->size, 1e-9 * diagonal);
    for (int s = 0; status == KN_OK && s < nsurfaces; s++)
        for (int along = 0; status == KN_OK && along < 2; along++)
            if (options->count[along] != 0) {
                counts[s][along] = options->count[along];
                status = check_count(ctx, &surfaces[s], s, along, counts[s][along]);
            }
    return status;
}
