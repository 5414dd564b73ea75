// SPDX-License-Identifier: Apache-2.0
// kn_cad_find.
#include "cad/near.h"
#include "io/color.h"
#include "io/text_scan.h"
#include "kernel/context.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SHOWN = 60 }; // bytes of a text, in a message

typedef struct find {
    kn_ctx *ctx;
    const kn_cad *cad;
    bool *chosen; // one for each face, so far
    bool *term;   // of the terms that '&' joins
    bool *factor; // of the one at hand
} find;

typedef struct part { // of the text, not ended by a zero byte
    const char *at;
    size_t n;
} part;

static char small(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

// Behind the first character of a name, of one byte or, in UTF-8, of several.
static const char *behind_one(const char *name)
{
    do name++;
    while (((unsigned char)*name & 0xc0) == 0x80);
    return name;
}

// Goes back to the last '*' where the text behind it does not agree.
static bool like(part pattern, const char *name)
{
    size_t i = 0, star = SIZE_MAX;
    const char *mark = name;
    while (*name) {
        if (i < pattern.n && pattern.at[i] == '*') {
            star = i++;
            mark = name;
        } else if (i < pattern.n && pattern.at[i] == '?') {
            i++;
            name = behind_one(name);
        } else if (i < pattern.n && small(pattern.at[i]) == small(*name)) {
            i++;
            name++;
        } else if (star != SIZE_MAX) {
            i = star + 1;
            name = mark = behind_one(mark);
        } else {
            return false;
        }
    }
    while (i < pattern.n && pattern.at[i] == '*') i++;
    return i == pattern.n;
}

static bool take_whole(part *p, int *out)
{
    long long value = 0;
    size_t digits = 0;
    for (; p->n > 0 && *p->at >= '0' && *p->at <= '9' && digits < 10; p->at++, p->n--, digits++)
        value = 10 * value + (*p->at - '0');
    *out = (int)(value <= INT32_MAX ? value : INT32_MAX);
    return digits > 0;
}

static kn_status bad_text(const find *f, part p)
{
    int n = (int)(p.n < SHOWN ? p.n : SHOWN);
    return kn_fail(f->ctx, KN_EDOMAIN,
                   "faces: expected numbers (0,3,5-9), name:, type:, color:#rrggbb, body: or near:X,Y,Z; got '%.*s'",
                   n, p.at);
}

static kn_status by_number(find *f, part p)
{
    const part all = p;
    for (bool more = true; more;) {
        int lo, hi;
        if (!take_whole(&p, &lo)) return bad_text(f, all);
        hi = lo;
        if (p.n > 0 && *p.at == '-') {
            p.at++, p.n--;
            if (!take_whole(&p, &hi) || hi < lo) return bad_text(f, all);
        }
        if (hi >= f->cad->nfaces)
            return kn_fail(f->ctx, KN_EDOMAIN, "faces: face %d; the file has 0 to %d", hi, f->cad->nfaces - 1);
        for (int i = lo; i <= hi; i++) f->factor[i] = true;
        more = p.n > 0 && *p.at == ',';
        if (more) p.at++, p.n--;
    }
    return p.n == 0 ? KN_OK : bad_text(f, all);
}

static int hex(char c)
{
    c = small(c);
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static kn_status by_color(find *f, part p)
{
    int wanted[3];
    bool good = p.n == 7 && *p.at == '#';
    for (int c = 0; good && c < 3; c++) {
        int high = hex(p.at[1 + 2 * c]), low = hex(p.at[2 + 2 * c]);
        good = high >= 0 && low >= 0;
        wanted[c] = 16 * high + low;
    }
    if (!good) return bad_text(f, p);
    for (int i = 0; i < f->cad->nfaces; i++) {
        const kn_cad_face *face = &f->cad->faces[i];
        f->factor[i] = face->colored;
        for (int c = 0; c < 3; c++)
            f->factor[i] = f->factor[i] && abs(kn_color_srgb_byte(face->color[c]) - wanted[c]) <= 1;
    }
    return KN_OK;
}

static kn_status by_place(find *f, part p)
{
    char text[128];
    double x[3];
    int commas = 0;
    if (p.n >= sizeof text) return bad_text(f, p);
    for (size_t i = 0; i < p.n; i++) {
        text[i] = p.at[i] == ',' ? ' ' : p.at[i];
        commas += p.at[i] == ',';
    }
    if (commas != 2) return bad_text(f, p);
    kn_scan scan = kn_scan_start(f->ctx, "faces", text, p.n);
    for (int c = 0; c < 3; c++) {
        kn_status status = kn_scan_real(&scan, &x[c], "coordinate");
        if (status == KN_OK) continue;
        if (status == KN_EPARSE) kn_ctx_clear_error(f->ctx); // it names no file
        return status == KN_EPARSE ? bad_text(f, p) : status;
    }
    int face = -1;
    kn_status status = kn_cad_nearest(f->ctx, &face, f->cad, f->term, x);
    if (status == KN_OK && face >= 0) f->factor[face] = true;
    return status;
}

static void by_body(find *f, part p)
{
    part rest = p;
    int number = -1;
    bool whole = take_whole(&rest, &number) && rest.n == 0, named = false;
    for (int b = 0; b < f->cad->nbodies; b++) named = named || like(p, f->cad->bodies[b].name);
    for (int i = 0; i < f->cad->nfaces; i++) {
        int b = f->cad->faces[i].body;
        f->factor[i] = named ? like(p, f->cad->bodies[b].name) : whole && b == number;
    }
}

// What a key can have in this file, each once: the first dozen.
typedef const char *label(const find *f, int face, char *room);

static const char *name_label(const find *f, int face, char *room)
{
    (void)room;
    return f->cad->faces[face].name;
}

static const char *body_label(const find *f, int face, char *room)
{
    (void)room;
    return f->cad->bodies[f->cad->faces[face].body].name;
}

static const char *type_label(const find *f, int face, char *room)
{
    (void)room;
    return kn_cad_type_name(f->cad->faces[face].type);
}

static const char *color_label(const find *f, int face, char *room)
{
    static const char digits[] = "0123456789abcdef";
    const kn_cad_face *g = &f->cad->faces[face];
    if (!g->colored) return "";
    room[0] = '#';
    for (int c = 0; c < 3; c++) {
        int x = kn_color_srgb_byte(g->color[c]);
        room[1 + 2 * c] = digits[x / 16], room[2 + 2 * c] = digits[x % 16];
    }
    room[7] = '\0';
    return room;
}

static kn_status none(const find *f, part p, label *of)
{
    enum { LISTED = 12 };
    char list[LISTED * (KN_NAME_BYTES + 2)] = "", room[8], other[8];
    int first[LISTED], n = 0, used = 0;
    for (int i = 0; i < f->cad->nfaces && n < LISTED; i++) {
        const char *word = of(f, i, room);
        bool known = *word == '\0';
        for (int k = 0; !known && k < n; k++) known = strcmp(of(f, first[k], other), word) == 0;
        if (known) continue;
        used += snprintf(list + used, sizeof list - (size_t)used, "%s%s", n > 0 ? ", " : "", word);
        first[n++] = i;
    }
    int shown = (int)(p.n < SHOWN ? p.n : SHOWN);
    return kn_fail(f->ctx, KN_EDOMAIN, "faces: none with %.*s; there is %s%s", shown, p.at, n > 0 ? list : "none",
                   n == LISTED ? ", .." : "");
}

static bool begins(part *p, const char *key)
{
    size_t n = strlen(key);
    if (p->n < n || memcmp(p->at, key, n) != 0) return false;
    p->at += n;
    p->n -= n;
    return true;
}

static kn_status find_factor(find *f, part p)
{
    const part all = p;
    const int nfaces = f->cad->nfaces;
    label *of = type_label;
    kn_status status = KN_OK;
    for (int i = 0; i < nfaces; i++) f->factor[i] = false;
    if (begins(&p, "name:")) {
        of = name_label;
        for (int i = 0; i < nfaces; i++) f->factor[i] = like(p, f->cad->faces[i].name);
    } else if (begins(&p, "type:")) {
        of = type_label;
        for (int i = 0; i < nfaces; i++) f->factor[i] = like(p, kn_cad_type_name(f->cad->faces[i].type));
    } else if (begins(&p, "body:")) {
        of = body_label;
        by_body(f, p);
    } else if (begins(&p, "color:") || begins(&p, "colour:")) {
        of = color_label;
        status = by_color(f, p);
    } else if (begins(&p, "near:")) {
        of = NULL;
        status = by_place(f, p);
    } else {
        status = by_number(f, p);
    }
    bool any = false;
    for (int i = 0; i < nfaces; i++) any = any || f->factor[i];
    return status == KN_OK && !any && of ? none(f, all, of) : status;
}

// Up to the next of these characters, which is skipped.
static part next_part(part *rest, char separator)
{
    const char *end = memchr(rest->at, separator, rest->n);
    part p = {rest->at, end ? (size_t)(end - rest->at) : rest->n};
    size_t skip = p.n + (end != NULL);
    rest->at += skip;
    rest->n -= skip;
    return p;
}

// What is near comes last: the nearest one of those that all else holds for.
static kn_status find_term(find *f, part all)
{
    kn_status status = KN_OK;
    bool any = false;
    for (int i = 0; i < f->cad->nfaces; i++) f->term[i] = true;
    for (int last = 0; last < 2; last++) {
        part rest = all;
        do {
            part one = next_part(&rest, '&'), key = one;
            if (begins(&key, "near:") != (last == 1)) continue;
            status = find_factor(f, one);
            for (int i = 0; status == KN_OK && i < f->cad->nfaces; i++) f->term[i] = f->term[i] && f->factor[i];
        } while (status == KN_OK && rest.n > 0);
    }
    for (int i = 0; status == KN_OK && i < f->cad->nfaces; i++) {
        f->chosen[i] = f->chosen[i] || f->term[i];
        any = any || f->term[i];
    }
    if (status == KN_OK && !any)
        return kn_fail(f->ctx, KN_EDOMAIN, "faces: none with all of %.*s", (int)(all.n < SHOWN ? all.n : SHOWN),
                       all.at);
    return status;
}

kn_status kn_cad_find(kn_ctx *ctx, int **faces, int *n, const kn_cad *cad, const char *text)
{
    if (cad->nfaces == 0) return kn_fail(ctx, KN_EDOMAIN, "faces: the model has none");
    size_t count = (size_t)cad->nfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    bool *flags = kn_scratch(ctx, 3 * count, sizeof *flags);
    int *found = kn_alloc(ctx, count, sizeof *found);
    kn_status status = flags && found ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        memset(flags, 0, 3 * count * sizeof *flags);
        find f = {ctx, cad, flags, flags + count, flags + 2 * count};
        part rest = {text, strlen(text)};
        do {
            status = find_term(&f, next_part(&rest, '+'));
        } while (status == KN_OK && rest.n > 0);
    }
    if (status == KN_OK) {
        *n = 0;
        for (int i = 0; i < cad->nfaces; i++)
            if (flags[i]) found[(*n)++] = i;
        *faces = found;
        found = NULL;
    }
    kn_free(ctx, found);
    kn_scratch_release(ctx, mark);
    return status;
}
