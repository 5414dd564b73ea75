// SPDX-License-Identifier: Apache-2.0
// How many cells each surface gets: the same on edges that surfaces share.
#include "job/internal.h"

#include <math.h>

// ---- classes of edges that must have one count: a forest, the root of each its edge of lowest number ----
typedef struct node {
    int parent;
    bool reversed; // against its parent
    bool mirrored; // of a root: the class meets itself backwards
} node;

// The root of e, and whether e runs against it.
static int root_of(bool *reversed, const node *nodes, int e)
{
    for (*reversed = false; nodes[e].parent != e; e = nodes[e].parent) *reversed ^= nodes[e].reversed;
    return e;
}

static void join(node *nodes, int a, int b, bool reversed)
{
    bool ra, rb;
    int x = root_of(&ra, nodes, a), y = root_of(&rb, nodes, b);
    bool between = reversed != (ra != rb);
    if (x == y) {
        nodes[x].mirrored |= between;
        return;
    }
    int low = x < y ? x : y, high = x < y ? y : x;
    nodes[high].parent = low;
    nodes[high].reversed = between;
    nodes[low].mirrored |= nodes[high].mirrored;
}

kn_status kn_job_find_classes(kn_ctx *ctx, kn_job_class *classes, const kn_job_partner *partners, int nsurfaces)
{
    int n = 4 * nsurfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    node *nodes = kn_scratch(ctx, (size_t)n, sizeof *nodes);
    for (int e = 0; nodes && e < n; e++) nodes[e] = (node){.parent = e};
    for (int e = 0; nodes && e < n; e += 2) join(nodes, e, e + 1, false); // opposite edges of a surface
    for (int e = 0; nodes && e < n; e++)
        if (partners[e].edge >= 0) join(nodes, e, partners[e].edge, partners[e].reversed);
    for (int m = 0; nodes && m < 2 * nsurfaces; m++) {
        bool reversed;
        int root = root_of(&reversed, nodes, 4 * (m / 2) + (m % 2 == 0 ? 2 : 0));
        classes[m] = (kn_job_class){.id = root, .reversed = reversed, .mirrored = nodes[root].mirrored};
    }
    kn_scratch_release(ctx, mark);
    return nodes ? KN_OK : KN_ENOMEM;
}

typedef struct edge_class {
    double sum; // of length / size over isoparametric curves
    int curves, spans;
    double *span; // the same for each knot span, where there are several and all members have as many
    int members;
} edge_class;

// A direction of a surface takes part in its class.
static kn_status add_member(kn_ctx *ctx, edge_class *c, const kn_job_class *member, const kn_spline *surface,
                            int along, double size)
{
    int spans = kn_spline_spans(surface, along);
    if (c->members++ == 0 && spans > 1) {
        c->span = kn_alloc_zero(ctx, (size_t)spans, sizeof *c->span);
        if (!c->span) return KN_ENOMEM;
    } else if (spans != c->spans) { // nothing to share out evenly
        kn_free(ctx, c->span);
        c->span = NULL;
    }
    c->spans = spans > c->spans ? spans : c->spans;
    if (!c->span) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    double lo, hi, *length = kn_scratch(ctx, (size_t)spans, sizeof *length);
    kn_spline_domain(surface, 1 - along, &lo, &hi);
    kn_status status = length ? kn_cells_span_lengths(ctx, length, surface, along, 0.5 * (lo + hi)) : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < spans; i++)
        c->span[member->reversed ? spans - 1 - i : i] += length[i] / size;
    kn_scratch_release(ctx, mark);
    return status;
}

// The mean of length / size over the curves, no fewer than knot spans. Even lines: the sum of the nearest counts of
// the spans, so that cells of all spans are as even, where that is within 15 % of it.
static double class_count(const edge_class *c)
{
    double count = fmax(round(c->sum / c->curves), fmax(1.0, c->spans)), sum = 0.0;
    if (!c->span) return count;
    for (int i = 0; i < c->spans; i++) sum += fmax(1.0, round(c->span[i] / c->members));
    return fabs(sum - count) <= 0.15 * count ? sum : count;
}

static kn_status count_classes(kn_ctx *ctx, edge_class *sums, int (*counts)[2], const kn_job *job,
                               const kn_spline *surfaces, const kn_job_measure *measures, const kn_job_class *classes)
{
    kn_status status = KN_OK;
    const double *size = job->options.size;
    for (int m = 0; status == KN_OK && m < 2 * job->nsurfaces; m++) {
        edge_class *c = &sums[classes[m].id];
        int s = m / 2, along = m % 2, spans = kn_spline_spans(&surfaces[s], along);
        for (int k = 0; k < 3; k++) c->sum += measures[s].length[along][k] / size[along];
        c->curves += 3;
        if (kn_job_is_even(job, along))
            status = add_member(ctx, c, &classes[m], &surfaces[s], along, size[along]);
        else
            c->spans = spans > c->spans ? spans : c->spans;
    }
    for (int m = 0; status == KN_OK && m < 2 * job->nsurfaces; m++) {
        double count = class_count(&sums[classes[m].id]);
        if (!(count <= KN_JOB_MAX_COUNT))
            status = kn_fail(ctx, KN_ELIMIT, "job: %.6g cells of size %g along surface %d, at most %d", count,
                             size[m % 2], m / 2, KN_JOB_MAX_COUNT);
        else
            counts[m / 2][m % 2] = (int)count;
    }
    return status;
}

static kn_status count_by_size(kn_ctx *ctx, int (*counts)[2], const kn_job *job, const kn_spline *surfaces,
                               const kn_job_measure *measures, const kn_job_class *classes)
{
    size_t n = 4 * (size_t)job->nsurfaces;
    edge_class *sums = kn_alloc_zero(ctx, n, sizeof *sums);
    if (!sums) return KN_ENOMEM;
    kn_status status = count_classes(ctx, sums, counts, job, surfaces, measures, classes);
    for (size_t i = 0; i < n; i++) kn_free(ctx, sums[i].span);
    kn_free(ctx, sums);
    return status;
}

kn_status kn_job_counts(kn_ctx *ctx, int (*counts)[2], const kn_job *job, const kn_spline *surfaces,
                        const kn_job_measure *measures, const kn_job_class *classes)
{
    const kn_job_options *o = &job->options;
    kn_status status = KN_OK;
    if (o->count[0] == 0 || o->count[1] == 0) status = count_by_size(ctx, counts, job, surfaces, measures, classes);
    for (int along = 0; status == KN_OK && along < 2; along++) {
        int count = o->count[along];
        if (count > KN_JOB_MAX_COUNT)
            status = kn_fail(ctx, KN_ELIMIT, "job: count %d, at most %d", count, KN_JOB_MAX_COUNT);
        for (int s = 0; status == KN_OK && count != 0 && s < job->nsurfaces; s++) {
            const int *part = job->surfaces[s].part;
            if (part[0] == 0 && part[1] == 0)
                status = kn_job_share_count(ctx, counts, job, s, along, count, surfaces, measures);
        }
    }
    for (int s = 0; status == KN_OK && s < job->nsurfaces; s++)
        for (int along = 0; along < 2; along++)
            if (job->surfaces[s].count[along] > 0) counts[s][along] = job->surfaces[s].count[along];
    return status;
}
