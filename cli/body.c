// SPDX-License-Identifier: Apache-2.0
// The conversation with knurl-cad about a body (bridges/occt/host.h says what is said).
#include "cli/body.h"
#include "io/text_buffer.h"
#include "io/text_scan.h"
#include "kernel/context.h"

#include <string.h>

// ---- the request ----

static kn_status put_point(kn_ctx *ctx, kn_text *text, const kn_spline *curve, double t)
{
    const double *knots = curve->knots[0];
    double lo = knots[curve->degree[0]], hi = knots[curve->count[0]], x[3], u = t == 1.0 ? hi : lo + t * (hi - lo);
    kn_status status = kn_spline_eval(ctx, x, curve, &u);
    for (int c = 0; c < 3 && status == KN_OK; c++) {
        kn_text_char(text, ' ');
        kn_text_plain_real(text, x[c], 17);
    }
    return status;
}

// Ends and two points inside each edge of a chain.
static kn_status put_chain(kn_ctx *ctx, kn_text *text, const cli_body_chain *chain)
{
    kn_status status = KN_OK;
    kn_text_put(text, "edge ");
    kn_text_integer(text, (uint64_t)chain->edge);
    kn_text_char(text, ' ');
    kn_text_integer(text, chain->n);
    for (size_t i = 0; i < chain->n && status == KN_OK; i++)
        for (int k = i == 0 ? 0 : 1; k <= 3 && status == KN_OK; k++)
            status = put_point(ctx, text, &chain->edges[i].curve, (chain->edges[i].along ? k : 3 - k) / 3.0);
    kn_text_newline(text);
    return status;
}

kn_status cli_body_request(kn_ctx *ctx, char **text, size_t *bytes, const cli_body_plan *plan, double tolerance)
{
    kn_text out = {.ctx = ctx};
    kn_status status = KN_OK;
    kn_text_put(&out, "knurl-host 1\nfaces ");
    kn_text_integer(&out, plan ? (uint64_t)plan->nreplaced : 0);
    for (int i = 0; plan && i < plan->nreplaced; i++) {
        kn_text_char(&out, ' ');
        kn_text_integer(&out, (uint64_t)plan->replaced[i]);
    }
    kn_text_put(&out, "\ntolerance ");
    kn_text_plain_real(&out, tolerance, 17);
    kn_text_newline(&out);
    for (size_t i = 0; plan && i < plan->nchains && status == KN_OK; i++)
        status = put_chain(ctx, &out, &plan->chains[i]);
    kn_text_put(&out, "end\n");
    if (status == KN_OK && out.failed) status = KN_ENOMEM;
    if (status != KN_OK) {
        kn_text_clear(&out);
        return status;
    }
    *text = out.data, *bytes = out.bytes;
    return KN_OK;
}

// ---- the answer ----

typedef struct reading {
    kn_ctx *ctx;
    kn_scan scan;
    cli_body *body;
    const cli_body_plan *plan;
    const int *face, *bodies; // of surfaces
    int nfaces;               // of all shells so far
    int nseeds;
    size_t nchains; // answered, in the order of the request
} reading;

static bool is_word(const reading *r, const char *word)
{
    return r->scan.length == strlen(word) && memcmp(r->scan.word, word, r->scan.length) == 0;
}

static kn_status read_number(reading *r, uint32_t *out, const char *what)
{
    int n = 0;
    kn_status status = kn_scan_int(&r->scan, &n, what, 0, INT32_MAX);
    if (status == KN_OK) *out = (uint32_t)n;
    return status;
}

static kn_status read_shell(reading *r)
{
    cli_body *b = r->body;
    uint32_t closed = 0, n = 0;
    kn_step_shell *shells = kn_resize(r->ctx, b->shells, (size_t)b->host.nshells + 1, sizeof *shells);
    if (!shells) return KN_ENOMEM;
    b->shells = shells;
    kn_step_shell *s = &shells[b->host.nshells];
    *s = (kn_step_shell){0};
    kn_status status = read_number(r, &s->number, "shell");
    if (status == KN_OK) status = read_number(r, &closed, "closed");
    if (status == KN_OK) status = read_number(r, &n, "number of faces");
    if (status == KN_OK) status = kn_scan_room(&r->scan, n, "faces");
    if (status != KN_OK) return status;
    uint32_t *faces = kn_resize(r->ctx, b->faces, (size_t)r->nfaces + n + 1, sizeof *faces);
    if (!faces) return KN_ENOMEM;
    b->faces = faces;
    for (uint32_t i = 0; i < n && status == KN_OK; i++)
        status = read_number(r, &faces[(uint32_t)r->nfaces + i], "face");
    s->closed = closed != 0, s->nfaces = (int)n;
    r->nfaces += (int)n;
    b->host.nshells++;
    return status;
}

static kn_status read_face(reading *r)
{
    int face = 0, shell = 0;
    kn_status status = kn_scan_int(&r->scan, &face, "face", 0, INT32_MAX);
    if (status == KN_OK) status = kn_scan_int(&r->scan, &shell, "shell", 0, r->body->host.nshells - 1);
    for (int s = 0; s < r->body->host.nsurfaces && status == KN_OK; s++)
        if (r->face[s] == face) r->body->shell_of[s] = shell;
    return status;
}

static kn_status read_seed(reading *r, const cli_body_chain *chain, const cli_border_edge *e)
{
    uint32_t number = 0, vertex[2] = {0}, along = 0;
    kn_status status = read_number(r, &number, "EDGE_CURVE");
    for (int k = 0; k < 2 && status == KN_OK; k++) status = read_number(r, &vertex[k], "VERTEX_POINT");
    if (status == KN_OK) status = read_number(r, &along, "direction");
    if (status != KN_OK) return status;
    // The answer runs from e->from to e->to, the curve perhaps not.
    r->body->seeds[r->nseeds++] = (kn_step_seed){.curve = e->curve,
                                                 .edge = number,
                                                 .vertex = {vertex[e->along ? 0 : 1], vertex[e->along ? 1 : 0]},
                                                 .along = (along != 0) == e->along,
                                                 .body = r->bodies[chain->surface],
                                                 .shell = r->body->shell_of[chain->surface],
                                                 .forward = chain->forward == e->along};
    return KN_OK;
}

static kn_status read_edge(reading *r)
{
    int edge = 0, n = 0;
    kn_status status = kn_scan_int(&r->scan, &edge, "edge", 0, INT32_MAX);
    const cli_body_chain *chain = r->plan && r->nchains < r->plan->nchains ? &r->plan->chains[r->nchains++] : NULL;
    if (status == KN_OK && (!chain || chain->edge != edge))
        return kn_scan_fail_word(&r->scan, "edge", "not the one that was asked for");
    if (status == KN_OK) status = kn_scan_int(&r->scan, &n, "number of parts", (int)chain->n, (int)chain->n);
    if (status != KN_OK) return status;
    kn_step_seed *seeds = kn_resize(r->ctx, r->body->seeds, (size_t)(r->nseeds + n), sizeof *seeds);
    if (!seeds) return KN_ENOMEM;
    r->body->seeds = seeds;
    for (size_t i = 0; i < chain->n && status == KN_OK; i++) status = read_seed(r, chain, &chain->edges[i]);
    return status;
}

// What follows the word, and a newline, are the entities.
static kn_status read_entities(reading *r)
{
    uint32_t bytes = 0;
    kn_status status = read_number(r, &r->body->host.numbers, "largest number");
    if (status == KN_OK) status = read_number(r, &bytes, "bytes");
    if (status != KN_OK) return status;
    const char *at = r->scan.word + r->scan.length;
    if (at == r->scan.end || *at != '\n' || (size_t)(r->scan.end - at - 1) != bytes)
        return kn_scan_fail(&r->scan, KN_EPARSE, "there are not the %u bytes of entities", bytes);
    r->body->host.entities = at + 1, r->body->host.bytes = bytes;
    return KN_OK;
}

static kn_status read_answer(reading *r)
{
    int version = 0;
    kn_status status = KN_OK;
    if (!kn_scan_word(&r->scan) || !is_word(r, "knurl-host")) return kn_scan_fail(&r->scan, KN_EPARSE, "no answer");
    status = kn_scan_int(&r->scan, &version, "version", 1, 1);
    while (status == KN_OK && !r->body->host.entities) {
        if (!kn_scan_word(&r->scan)) return kn_scan_fail(&r->scan, KN_EPARSE, "no entities");
        status = is_word(r, "context")    ? read_number(r, &r->body->host.context, "context")
                 : is_word(r, "gap")      ? kn_scan_real(&r->scan, &r->body->gap, "gap")
                 : is_word(r, "shell")    ? read_shell(r)
                 : is_word(r, "face")     ? read_face(r)
                 : is_word(r, "edge")     ? read_edge(r)
                 : is_word(r, "entities") ? read_entities(r)
                                          : kn_scan_fail_word(&r->scan, "word", "not known");
    }
    return status;
}

kn_status cli_body_parse(kn_ctx *ctx, cli_body *out, const char *name, char *text, size_t bytes,
                         const cli_body_plan *plan, const int *face, const cli_base *base)
{
    int nsurfaces = base->nsurfaces;
    cli_body b = {.host.nsurfaces = nsurfaces};
    reading r = {ctx, kn_scan_start(ctx, name, text, bytes), &b, plan, face, base->body, 0, 0, 0};
    b.shell_of = kn_alloc(ctx, (size_t)nsurfaces, sizeof *b.shell_of);
    for (int s = 0; b.shell_of && s < nsurfaces; s++) b.shell_of[s] = -1;
    kn_status status = b.shell_of ? read_answer(&r) : KN_ENOMEM;
    if (status != KN_OK) {
        cli_body_clear(ctx, &b);
        return status;
    }
    for (int i = 0, first = 0; i < b.host.nshells; first += b.shells[i++].nfaces) b.shells[i].faces = b.faces + first;
    b.host.shells = b.shells, b.host.shell_of = b.shell_of, b.host.seeds = b.seeds, b.host.nseeds = r.nseeds;
    b.replaced = plan ? plan->nreplaced : 0;
    b.text = text;
    *out = b;
    return KN_OK;
}

void cli_body_clear(kn_ctx *ctx, cli_body *body)
{
    kn_free(ctx, body->text);
    kn_free(ctx, body->shells);
    kn_free(ctx, body->faces);
    kn_free(ctx, body->shell_of);
    kn_free(ctx, body->seeds);
    *body = (cli_body){0};
}
