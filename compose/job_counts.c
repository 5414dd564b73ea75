// SPDX-License-Identifier: Apache-2.0
// How many cells each surface gets: the same on edges that surfaces share.
#include "compose/job.h"

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
} edge_class;

// The count of each class: the mean of length / size over its curves, no fewer than any member has knot spans.
static kn_status count_by_size(kn_ctx *ctx, int (*counts)[2], const kn_spline *surfaces, int nsurfaces,
                               const kn_job_measure *measures, const double size[2], const kn_job_class *classes)
{
    edge_class *sums = kn_alloc_zero(ctx, 4 * (size_t)nsurfaces, sizeof *sums);
    kn_status status = sums ? KN_OK : KN_ENOMEM;
    for (int s = 0; status == KN_OK && s < nsurfaces; s++)
        for (int along = 0; along < 2; along++) {
            edge_class *c = &sums[classes[2 * s + along].id];
            for (int k = 0; k < 3; k++) c->sum += measures[s].length[along][k] / size[along];
            int spans = kn_spline_spans(&surfaces[s], along);
            c->curves += 3;
            c->spans = spans > c->spans ? spans : c->spans;
        }
    for (int s = 0; status == KN_OK && s < nsurfaces; s++)
        for (int along = 0; status == KN_OK && along < 2; along++) {
            const edge_class *c = &sums[classes[2 * s + along].id];
            double count = fmax(round(c->sum / c->curves), fmax(1.0, c->spans));
            if (!(count <= KN_JOB_MAX_COUNT))
                status = kn_fail(ctx, KN_ELIMIT, "job: %.0f cells of size %g along surface %d, at most %d", count,
                                 size[along], s, KN_JOB_MAX_COUNT);
            else
                counts[s][along] = (int)count;
        }
    kn_free(ctx, sums);
    return status;
}

kn_status kn_job_counts(kn_ctx *ctx, int (*counts)[2], const kn_job *job, const kn_spline *surfaces,
                        const kn_job_measure *measures, const kn_job_class *classes)
{
    const kn_job_options *o = &job->options;
    kn_status status = KN_OK;
    if (o->count[0] == 0 || o->count[1] == 0)
        status = count_by_size(ctx, counts, surfaces, job->nsurfaces, measures, o->size, classes);
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
