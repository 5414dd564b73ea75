// SPDX-License-Identifier: Apache-2.0
// How many cells each surface gets: the same on edges that surfaces share.
#include "compose/job.h"

#include <math.h>

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

static void find_classes(int *parent, const kn_job_partner *partners, int nsurfaces)
{
    int n = 4 * nsurfaces;
    for (int e = 0; e < n; e++) parent[e] = e;
    for (int e = 0; e < n; e += 2) join(parent, e, e + 1); // opposite edges of a surface
    for (int e = 0; e < n; e++)
        if (partners[e].edge >= 0) join(parent, e, partners[e].edge);
}

typedef struct edge_class {
    double sum; // of length / size over isoparametric curves
    int curves, spans;
} edge_class;

// The count of each class: the mean of length / size over its curves, no fewer than any member has knot spans.
static kn_status count_by_size(kn_ctx *ctx, int (*counts)[2], const kn_spline *surfaces, int nsurfaces,
                               const kn_job_measure *measures, const double size[2], const kn_job_partner *partners)
{
    int *parent = kn_alloc(ctx, 4 * (size_t)nsurfaces, sizeof *parent);
    edge_class *classes = kn_alloc_zero(ctx, 4 * (size_t)nsurfaces, sizeof *classes);
    kn_status status = parent && classes ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) find_classes(parent, partners, nsurfaces);
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
                        const kn_job_measure *measures, const kn_job_options *options, const kn_job_partner *partners)
{
    kn_status status = KN_OK;
    if (options->count[0] == 0 || options->count[1] == 0)
        status = count_by_size(ctx, counts, surfaces, nsurfaces, measures, options->size, partners);
    for (int s = 0; status == KN_OK && s < nsurfaces; s++)
        for (int along = 0; status == KN_OK && along < 2; along++)
            if (options->count[along] != 0) {
                counts[s][along] = options->count[along];
                status = check_count(ctx, &surfaces[s], s, along, counts[s][along]);
            }
    return status;
}
