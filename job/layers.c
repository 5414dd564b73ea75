// SPDX-License-Identifier: Apache-2.0
// kn_job_run_layers: several jobs into one set of sinks, which see one job with the parts of all tiles.
#include "job/run.h"
#include "kernel/context.h"
#include "kernel/hash.h"

#include <knurl/job.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

// What stands between one job and one sink: patches are told which layer they are of, and counted on.
typedef struct layer {
    kn_sink *sink;
    const kn_tile *tile; // of all layers
    const kn_job_report *report;
    int number, first_part, first_look;
    size_t first_patch;
} layer;

typedef struct product {
    kn_patch_block block;
    kn_patch *patches;
    void *of_sink;
} product;

static void layer_discard(kn_ctx *ctx, void *user, void *made)
{
    const layer *l = user;
    product *p = made;
    if (!p) return;
    if (p->of_sink && l->sink->discard) l->sink->discard(ctx, l->sink->user, p->of_sink);
    kn_free(ctx, p->patches);
    kn_free(ctx, p);
}

static kn_status layer_work(kn_ctx *worker, void *user, const kn_patch_block *block, void **out)
{
    const layer *l = user;
    product *p = kn_alloc_zero(worker, 1, sizeof *p);
    if (!p) return KN_ENOMEM;
    p->patches = kn_alloc(worker, block->count, sizeof *p->patches);
    kn_status status = p->patches ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < block->count; i++) {
        p->patches[i] = block->patches[i];
        p->patches[i].id.layer = l->number;
        p->patches[i].id.part += l->first_part;
        p->patches[i].look += l->first_look;
    }
    p->block = (kn_patch_block){l->first_patch + block->first, block->count, p->patches};
    if (status == KN_OK && l->sink->work) status = l->sink->work(worker, l->sink->user, &p->block, &p->of_sink);
    if (status == KN_OK)
        *out = p;
    else
        layer_discard(worker, user, p);
    return status;
}

static kn_status layer_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *made)
{
    (void)block;
    const layer *l = user;
    product *p = made;
    kn_status status = l->sink->commit(ctx, l->sink->user, &p->block, p->of_sink);
    p->of_sink = NULL;
    layer_discard(ctx, user, p);
    return status;
}

static kn_status layer_save(kn_ctx *ctx, void *user, unsigned char **data, size_t *bytes)
{
    const layer *l = user;
    return l->sink->save(ctx, l->sink->user, data, bytes);
}

static kn_status layer_restore(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report,
                               const unsigned char *data, size_t bytes)
{
    (void)tile, (void)report;
    const layer *l = user;
    return l->sink->restore(ctx, l->sink->user, l->tile, l->report, data, bytes);
}

// ---- what the sinks see ----

static bool is_taken(const kn_tile_part *parts, int n, const char *name)
{
    for (int i = 0; i < n; i++)
        if (strcmp(parts[i].name, name) == 0) return true;
    return false;
}

// A name of another layer's part gets a number, for files tell parts apart by their names.
static void name_part(kn_tile_part *parts, int n, int number)
{
    char name[KN_NAME_BYTES];
    memcpy(name, parts[n].name, sizeof name);
    name[KN_NAME_BYTES - 16] = '\0';
    for (int k = number + 1; is_taken(parts, n, parts[n].name) && k < number + 1 + n + 1; k++)
        (void)snprintf(parts[n].name, sizeof parts[n].name, "%s %d", name, k);
}

// Parts are borrowed; the list is to be freed.
static kn_status join_tiles(kn_ctx *ctx, kn_tile *out, const kn_job *const *jobs, int njobs)
{
    kn_tile all = {.name = "layers", .aspect = 1.0};
    for (int k = 0; k < njobs; k++) all.nparts += kn_job_look_tile(jobs[k])->nparts;
    all.parts = kn_alloc(ctx, (size_t)all.nparts, sizeof *all.parts);
    if (!all.parts) return KN_ENOMEM;
    int n = 0;
    for (int k = 0; k < njobs; k++) {
        const kn_tile *tile = kn_job_look_tile(jobs[k]);
        all.covering = all.covering || tile->covering;
        for (int p = 0; p < tile->nparts; p++, n++) {
            all.parts[n] = tile->parts[p];
            all.parts[n].targets = NULL;
            all.parts[n].mesh_targets = NULL;
            name_part(all.parts, n, k);
        }
    }
    *out = all;
    return KN_OK;
}

static void add_report(kn_job_report *to, const kn_job_report *r)
{
    to->nsurfaces += r->nsurfaces;
    to->nparts += r->nparts;
    to->cells += r->cells;
    to->patches += r->patches;
    to->exact_patches += r->exact_patches;
    to->control_points += r->control_points;
    to->triangles += r->triangles;
    to->curves += r->curves;
    to->volumes += r->volumes;
    to->meshes += r->meshes;
    for (int k = 0; k < KN_DROP_REASONS; k++) to->dropped[k] += r->dropped[k];
    for (int d = 0; d < 2; d++) to->degree[d] = r->degree[d] > to->degree[d] ? r->degree[d] : to->degree[d];
    to->normal.length_error = fmax(to->normal.length_error, r->normal.length_error);
    to->normal.angle_error = fmax(to->normal.angle_error, r->normal.angle_error);
    to->normal.certified = to->normal.certified && r->normal.certified;
    to->normal_tol = fmax(to->normal_tol, r->normal_tol);
    to->max_degree = r->max_degree > to->max_degree ? r->max_degree : to->max_degree;
    to->stand_in_error = fmax(to->stand_in_error, r->stand_in_error);
    to->crossing_error = fmax(to->crossing_error, r->crossing_error);
    to->jacobian_lo = fmin(to->jacobian_lo, r->jacobian_lo);
    to->jacobian_hi = fmax(to->jacobian_hi, r->jacobian_hi);
    to->cells_error = fmax(to->cells_error, r->cells_error);
    to->stretch_error = fmax(to->stretch_error, r->stretch_error);
    to->even_instead += r->even_instead;
}

kn_job_report kn_job_describe_layers(const kn_job *const *jobs, int njobs)
{
    kn_job_report all = njobs > 0 ? kn_job_describe(jobs[0]) : (kn_job_report){0};
    for (int k = 1; k < njobs; k++) {
        kn_job_report r = kn_job_describe(jobs[k]);
        add_report(&all, &r);
    }
    return all;
}

// ---- the run ----

// Before the state of the layer that is at work.
enum { WORDS = 3 };
static const uint64_t version = 0x6b6e75726c100001u;

// What is noted while a layer runs.
typedef struct layer_notes {
    const kn_job_notes *all;
    uint64_t head[WORDS]; // version, which layer, of how many
} layer_notes;

static kn_status note(kn_ctx *ctx, void *user, const unsigned char *state, size_t bytes)
{
    const layer_notes *n = user;
    unsigned char *data = kn_alloc(ctx, sizeof n->head + bytes, 1);
    if (!data) return KN_ENOMEM;
    memcpy(data, n->head, sizeof n->head);
    memcpy(data + sizeof n->head, state, bytes);
    kn_status status = n->all->note(ctx, n->all->user, data, sizeof n->head + bytes);
    kn_free(ctx, data);
    return status;
}

// Where to go on.
static kn_status find_layer(kn_ctx *ctx, int *first, const kn_job_notes *notes, int njobs)
{
    uint64_t head[WORDS];
    *first = 0;
    if (!notes || !notes->state) return KN_OK;
    if (notes->bytes < sizeof head) return kn_fail(ctx, KN_EDOMAIN, "job: no state of a run");
    memcpy(head, notes->state, sizeof head);
    if (head[0] != version || head[2] != (uint64_t)njobs || head[1] >= head[2])
        return kn_fail(ctx, KN_EDOMAIN, "job: the interrupted run had other layers, or its state is damaged");
    *first = (int)head[1];
    return KN_OK;
}

// identity: of all layers. resumed: the sinks are as they were while this layer ran.
static kn_status run_layer(kn_ctx *ctx, const kn_job *job, kn_sink *proxies, int nsinks, layer_notes *notes,
                           uint64_t identity, bool resumed)
{
    if (!notes->all) return kn_job_run(ctx, job, proxies, nsinks);
    kn_job_notes own = {.user = notes,
                        .note = notes->all->note ? note : NULL,
                        .seconds = notes->all->seconds,
                        .identity = kn_hash_add(identity, notes->head[1])};
    if (resumed)
        own.state = notes->all->state + sizeof notes->head, own.bytes = notes->all->bytes - sizeof notes->head;
    return kn_job_run_from(ctx, job, proxies, nsinks, &own);
}

static void pass(layer *layers, int nsinks, const kn_job *job)
{
    for (int i = 0; i < nsinks; i++) {
        layers[i].number++;
        layers[i].first_part += kn_job_tile(job)->nparts;
        layers[i].first_look += kn_job_look_tile(job)->nparts;
        layers[i].first_patch += kn_job_describe(job).patches;
    }
}

static kn_status run_layers(kn_ctx *ctx, const kn_job *const *jobs, int njobs, layer *layers, kn_sink *proxies,
                            int nsinks, const kn_job_notes *notes)
{
    layer_notes own = {notes, {version, 0, (uint64_t)njobs}};
    uint64_t identity = notes ? notes->identity : 0;
    int first = 0;
    kn_status status = find_layer(ctx, &first, notes, njobs);
    bool resumed = notes && notes->state;
    for (int k = 0; notes && k < njobs; k++) identity = kn_job_identity(jobs[k], identity);
    for (int i = 0; status == KN_OK && i < nsinks && !resumed; i++)
        if (layers[i].sink->begin)
            status = layers[i].sink->begin(ctx, layers[i].sink->user, layers[i].tile, layers[i].report);
    for (int k = 0; status == KN_OK && k < njobs; k++) {
        own.head[1] = (uint64_t)k;
        if (k >= first) status = run_layer(ctx, jobs[k], proxies, nsinks, &own, identity, resumed && k == first);
        pass(layers, nsinks, jobs[k]);
    }
    for (int i = 0; status == KN_OK && i < nsinks; i++)
        if (layers[i].sink->end) status = layers[i].sink->end(ctx, layers[i].sink->user);
    return status;
}

static kn_status check_sinks(kn_ctx *ctx, const kn_sink *sinks, int nsinks, bool noted)
{
    for (int i = 0; i < nsinks; i++) {
        if (!sinks[i].commit) return kn_fail(ctx, KN_EDOMAIN, "job: sink %d is closed, or has no commit", i);
        if (noted && (!sinks[i].save || !sinks[i].restore))
            return kn_fail(ctx, KN_EDOMAIN, "job: sink %d cannot be interrupted and gone on with", i);
    }
    return KN_OK;
}

kn_status kn_job_run_layers_from(kn_ctx *ctx, const kn_job *const *jobs, int njobs, kn_sink *sinks, int nsinks,
                                 const kn_job_notes *notes)
{
    if (njobs < 1) return kn_fail(ctx, KN_EDOMAIN, "job: %d layers", njobs);
    kn_status status = check_sinks(ctx, sinks, nsinks, notes != NULL);
    if (status != KN_OK) return status;
    kn_tile tile = {0};
    const kn_job_report report = kn_job_describe_layers(jobs, njobs);
    layer *layers = kn_alloc_zero(ctx, (size_t)nsinks, sizeof *layers);
    kn_sink *proxies = kn_alloc_zero(ctx, (size_t)nsinks, sizeof *proxies);
    status = layers && proxies ? join_tiles(ctx, &tile, jobs, njobs) : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < nsinks; i++) {
        layers[i] = (layer){.sink = &sinks[i], .tile = &tile, .report = &report};
        proxies[i] = (kn_sink){.user = &layers[i],
                               .work = layer_work,
                               .commit = layer_commit,
                               .discard = layer_discard,
                               .save = layer_save,
                               .restore = layer_restore};
    }
    if (status == KN_OK) status = run_layers(ctx, jobs, njobs, layers, proxies, nsinks, notes);
    kn_free(ctx, tile.parts);
    kn_free(ctx, layers);
    kn_free(ctx, proxies);
    return status;
}

kn_status kn_job_run_layers(kn_ctx *ctx, const kn_job *const *jobs, int njobs, kn_sink *sinks, int nsinks)
{
    return kn_job_run_layers_from(ctx, jobs, njobs, sinks, nsinks, NULL);
}
