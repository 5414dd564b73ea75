// SPDX-License-Identifier: Apache-2.0
// Rows of cells with counts of their own: each part of a base becomes bands across its variable 1.
#include "job/internal.h"

// Of one part; NULL: it stays whole.
typedef struct part_bands {
    kn_cells_band *list;
    int n;
} part_bands;

typedef struct rows {
    const kn_job_bases *bases;
    const kn_job_class *classes;
    part_bands *bands;
    double size[2];
} rows;

// Parts of one origin beside each other have the same rows, whether their common edge is a curve or a point.
static kn_status find_classes(kn_ctx *ctx, kn_job_class *classes, const kn_job_bases *bases, double tol)
{
    kn_mark mark = kn_scratch_mark(ctx);
    kn_job_partner *partners = kn_scratch(ctx, 4 * (size_t)bases->n, sizeof *partners);
    int *bodies = kn_scratch(ctx, (size_t)bases->n, sizeof *bodies);
    kn_status status = partners && bodies ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < bases->n; i++) bodies[i] = bases->list[i].body;
    if (status == KN_OK) status = kn_job_find_partners(ctx, partners, bases->faces, bodies, bases->n, tol);
    for (int i = 0; status == KN_OK && i < bases->n; i++) {
        const kn_job_base *b = &bases->list[i];
        if (b->part[0] + 1 < b->parts[0] && partners[4 * i + 1].edge < 0)
            partners[4 * i + 1] = (kn_job_partner){.edge = 4 * (i + b->parts[1])};
    }
    if (status == KN_OK) status = kn_job_find_classes(ctx, classes, partners, bases->n);
    kn_scratch_release(ctx, mark);
    return status;
}

// The bands of part `first` and of all later ones whose variable 1 is of its class. Where that class goes on along
// the variable 0 of a surface, or meets itself backwards, there are no bands.
static kn_status cut_class(kn_ctx *ctx, rows *r, int first)
{
    int id = r->classes[2 * first + 1].id, n = 0, nbands, at = 0;
    if (r->classes[2 * first + 1].mirrored) return KN_OK;
    for (int m = 0; m < r->bases->n; m++) {
        if (r->classes[2 * m].id == id) return KN_OK;
        n += r->classes[2 * m + 1].id == id;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    kn_cells_along *along = kn_scratch(ctx, (size_t)n, sizeof *along);
    kn_cells_band *all = NULL;
    for (int m = first; along && m < r->bases->n; m++)
        if (r->classes[2 * m + 1].id == id)
            along[at++] = (kn_cells_along){&r->bases->faces[m], 1, r->classes[2 * m + 1].reversed};
    kn_status status = along ? kn_cells_shared_bands(ctx, &all, &nbands, along, n, r->size) : KN_ENOMEM;
    at = 0;
    for (int m = first; status == KN_OK && m < r->bases->n; m++) {
        if (r->classes[2 * m + 1].id != id) continue;
        part_bands *to = &r->bands[m];
        to->n = nbands;
        to->list = kn_alloc(ctx, (size_t)nbands, sizeof *to->list);
        if (!to->list) status = KN_ENOMEM;
        for (int k = 0; status == KN_OK && k < nbands; k++) to->list[k] = all[at + k];
        at += nbands;
    }
    kn_free(ctx, all);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status restrict_field(kn_ctx *ctx, kn_spline *out, const kn_spline *field, const kn_spline *face)
{
    double lo[2], hi[2];
    if (!field->coef) return KN_OK;
    for (int v = 0; v < 2; v++) kn_spline_domain(face, v, &lo[v], &hi[v]);
    return kn_spline_restrict(ctx, out, field, lo, hi);
}

// One band of a part, appended to bases, which has the room. Empty band: the whole part.
static kn_status add_band(kn_ctx *ctx, kn_job_bases *bases, const kn_job_base *part, const kn_spline *face,
                          const kn_cells_band *band)
{
    kn_job_base *to = &bases->list[bases->n];
    kn_spline *s = &bases->faces[bases->n++];
    double lo[2], hi[2];
    *to = (kn_job_base){
        .origin = part->origin, .body = part->body, .part = {part->part[0], 0}, .parts = {part->parts[0], 0}};
    *s = (kn_spline){0};
    for (int v = 0; v < 2; v++) kn_spline_domain(face, v, &lo[v], &hi[v]);
    if (band) lo[1] = band->lo, hi[1] = band->hi;
    for (int v = 0; band && v < 2; v++) to->count[v] = band->count[v];
    kn_status status = kn_spline_restrict(ctx, s, face, lo, hi);
    if (status == KN_OK) status = restrict_field(ctx, &to->thickness, &part->thickness, s);
    if (status == KN_OK) status = restrict_field(ctx, &to->direction, &part->direction, s);
    if (status == KN_OK) status = restrict_field(ctx, &to->attraction, &part->attraction, s);
    return status;
}

// part[1] and parts[1] anew: parts of one origin and one part[0] follow one another.
static void number_parts(kn_job_bases *bases)
{
    for (int i = 0; i < bases->n; i++) {
        kn_job_base *b = &bases->list[i];
        bool goes_on = i > 0 && b[-1].origin == b->origin && b[-1].part[0] == b->part[0];
        b->part[1] = goes_on ? b[-1].part[1] + 1 : 0;
    }
    for (int i = bases->n - 1; i >= 0; i--) {
        kn_job_base *b = &bases->list[i];
        bool last = i == bases->n - 1 || b[1].origin != b->origin || b[1].part[0] != b->part[0];
        b->parts[1] = last ? b->part[1] + 1 : b[1].parts[1];
    }
}

static kn_status replace_parts(kn_ctx *ctx, kn_job_bases *bases, const rows *r)
{
    kn_job_bases cut = {.n = 0};
    for (int m = 0; m < bases->n; m++) cut.room += r->bands[m].list ? r->bands[m].n : 1;
    cut.list = kn_alloc(ctx, (size_t)cut.room, sizeof *cut.list);
    cut.faces = kn_alloc(ctx, (size_t)cut.room, sizeof *cut.faces);
    kn_status status = cut.list && cut.faces ? KN_OK : KN_ENOMEM;
    for (int m = 0; status == KN_OK && m < bases->n; m++)
        for (int k = 0; status == KN_OK && k < (r->bands[m].list ? r->bands[m].n : 1); k++)
            status = add_band(ctx, &cut, &bases->list[m], &bases->faces[m],
                              r->bands[m].list ? &r->bands[m].list[k] : NULL);
    if (status == KN_OK) {
        number_parts(&cut);
        kn_job_bases swap = *bases;
        *bases = cut;
        cut = swap;
    }
    kn_job_bases_clear(ctx, &cut);
    return status;
}

static kn_status check(kn_ctx *ctx, const kn_job_bases *bases, const kn_job *job)
{
    if (job->tile.covering)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: rows of different counts do not meet, and the tile \"%s\" is to cover the base",
                       job->tile.name);
    if (job->options.count[0] != 0 || job->options.count[1] != 0)
        return kn_fail(ctx, KN_EDOMAIN, "job: rows of different counts come from a size, not from counts");
    if (bases->list[0].volume.coef) return kn_fail(ctx, KN_EDOMAIN, "job: rows of different counts over a volume");
    return KN_OK;
}

kn_status kn_job_cut_rows(kn_ctx *ctx, kn_job_bases *bases, const kn_job *job)
{
    double diagonal;
    size_t n = (size_t)bases->n;
    kn_status status = check(ctx, bases, job);
    if (status == KN_OK) status = kn_job_diagonal(ctx, &diagonal, bases->faces, bases->n);
    if (status != KN_OK) return status;
    rows r = {.bases = bases};
    kn_job_options o = job->options;
    kn_job_resolve_size(&o, diagonal);
    for (int d = 0; d < 2; d++) r.size[d] = o.size[d];
    kn_job_class *classes = kn_alloc(ctx, 2 * n, sizeof *classes);
    r.bands = kn_alloc_zero(ctx, n, sizeof *r.bands);
    r.classes = classes;
    status = classes && r.bands ? find_classes(ctx, classes, bases, 1e-9 * diagonal) : KN_ENOMEM;
    for (int m = 0; status == KN_OK && m < bases->n; m++) {
        bool met = false; // its class has a part before it, and has its bands
        for (int k = 0; !met && k < m; k++) met = classes[2 * k + 1].id == classes[2 * m + 1].id;
        if (!met) status = cut_class(ctx, &r, m);
    }
    if (status == KN_OK) status = replace_parts(ctx, bases, &r);
    for (size_t m = 0; r.bands && m < n; m++) kn_free(ctx, r.bands[m].list);
    kn_free(ctx, r.bands);
    kn_free(ctx, classes);
    return status;
}
