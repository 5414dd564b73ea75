// SPDX-License-Identifier: Apache-2.0
// Text that grows while it is formatted.
#include "io/text_buffer.h"
#include "io/decimal.h"
#include "kernel/context.h"

#include <string.h>

enum {
    FIRST_ROOM = 4096,
    LONG_ROOM = 1 << 20, // from which on a text grows by less than as much again
    LINE_BYTES = 100,
    RELATIVE = 1, // no text has a character 1
    RELATIVE_BYTES = 5
};

void kn_text_clear(kn_text *text)
{
    kn_free(text->ctx, text->data);
    text->data = NULL;
    text->bytes = text->room = text->line = 0;
}

kn_status kn_text_fit(kn_text *text)
{
    if (text->failed) return KN_ENOMEM;
    if (text->bytes == 0 || text->bytes == text->room) return KN_OK;
    char *smaller = kn_resize(text->ctx, text->data, text->bytes, 1);
    if (!smaller) return KN_ENOMEM;
    text->data = smaller, text->room = text->bytes;
    return KN_OK;
}

// A place for `bytes` more bytes, or NULL.
static char *reserve(kn_text *text, size_t bytes)
{
    if (text->failed) return NULL;
    if (text->room - text->bytes < bytes) {
        size_t room = text->room > 0 ? text->room : FIRST_ROOM;
        while (room - text->bytes < bytes) room += room < LONG_ROOM ? room : room / 4;
        char *larger = text->data == NULL ? kn_alloc(text->ctx, room, 1) : kn_resize(text->ctx, text->data, room, 1);
        text->failed = larger == NULL;
        if (text->failed) return NULL;
        text->data = larger, text->room = room;
    }
    return text->data + text->bytes;
}

void kn_text_bytes(kn_text *text, const void *data, size_t bytes)
{
    char *to = reserve(text, bytes);
    if (to == NULL) return;
    memcpy(to, data, bytes);
    text->bytes += bytes;
}

void kn_text_put(kn_text *text, const char *string)
{
    kn_text_bytes(text, string, strlen(string));
}

void kn_text_char(kn_text *text, char c)
{
    kn_text_bytes(text, &c, 1);
}

void kn_text_integer(kn_text *text, uint64_t n)
{
    char *to = reserve(text, KN_DECIMAL_BYTES);
    if (to != NULL) text->bytes += kn_decimal_integer(to, n);
}

void kn_text_reference(kn_text *text, uint64_t n)
{
    kn_text_char(text, '#');
    kn_text_integer(text, n);
}

void kn_text_relative(kn_text *text, uint32_t offset)
{
    char *to = reserve(text, RELATIVE_BYTES);
    if (to == NULL) return;
    to[0] = RELATIVE;
    memcpy(to + 1, &offset, sizeof offset);
    text->bytes += RELATIVE_BYTES;
}

void kn_text_expand(kn_text *text, const char *data, size_t bytes, uint64_t base)
{
    const char *end = data + bytes;
    while (data < end) {
        const char *at = memchr(data, RELATIVE, (size_t)(end - data));
        kn_text_bytes(text, data, (size_t)((at != NULL ? at : end) - data));
        if (at == NULL) return;
        uint32_t offset;
        memcpy(&offset, at + 1, sizeof offset);
        kn_text_reference(text, base + offset);
        data = at + RELATIVE_BYTES;
    }
}

void kn_text_step_real(kn_text *text, double x)
{
    char *to = reserve(text, KN_DECIMAL_BYTES);
    if (to != NULL) text->bytes += kn_decimal_step(to, x);
}

void kn_text_plain_real(kn_text *text, double x, int significant)
{
    char *to = reserve(text, KN_DECIMAL_BYTES);
    if (to != NULL) text->bytes += kn_decimal_plain(to, x, significant);
}

void kn_text_newline(kn_text *text)
{
    kn_text_char(text, '\n');
    text->line = text->bytes;
}

void kn_text_comma(kn_text *text)
{
    kn_text_char(text, ',');
    if (text->bytes - text->line > LINE_BYTES) kn_text_newline(text);
}

static void put_hex(kn_text *text, uint32_t value, int digits)
{
    for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4)
        kn_text_char(text, "0123456789ABCDEF"[(value >> shift) & 15]);
}

// The code point of a UTF-8 sequence at s, and its length; a byte that starts none counts as Latin-1.
static uint32_t code_point(const unsigned char *s, int *length)
{
    int more = s[0] >= 0xf0 && s[0] < 0xf8 ? 3 : s[0] >= 0xe0 ? 2 : s[0] >= 0xc0 ? 1 : 0;
    if (s[0] >= 0xf8) more = 0;
    uint32_t code = more == 0 ? s[0] : (uint32_t)(s[0] & (0x3f >> more));
    *length = 1;
    for (int i = 1; i <= more; i++) {
        if ((s[i] & 0xc0) != 0x80) return s[0];
        code = (code << 6) | (s[i] & 0x3f);
    }
    *length = more + 1;
    return code;
}

// ISO 10303-21: \X2\hhhh\X0\ for the basic plane, \X4\hhhhhhhh\X0\ beyond, \X\hh for other bytes.
static void put_encoded(kn_text *text, uint32_t code)
{
    if (code < 256) {
        kn_text_put(text, "\\X\\");
        put_hex(text, code, 2);
        return;
    }
    kn_text_put(text, code < 0x10000 ? "\\X2\\" : "\\X4\\");
    put_hex(text, code, code < 0x10000 ? 4 : 8);
    kn_text_put(text, "\\X0\\");
}

void kn_text_step_string(kn_text *text, const char *string)
{
    kn_text_char(text, '\'');
    int length = 1;
    for (const unsigned char *s = (const unsigned char *)string; *s != '\0'; s += length) {
        uint32_t code = code_point(s, &length);
        if (code == '\'' || code == '\\') kn_text_char(text, (char)code);
        if (code >= 32 && code < 127)
            kn_text_char(text, (char)code);
        else
            put_encoded(text, code);
    }
    kn_text_char(text, '\'');
}

void kn_text_utf8(kn_text *text, const char *string)
{
    int length = 1;
    for (const unsigned char *s = (const unsigned char *)string; *s != '\0'; s += length) {
        uint32_t code = code_point(s, &length);
        bool none = code < 32 || code == 127 || (code >= 0xd800 && code < 0xe000) || (code & 0xfffe) == 0xfffe;
        if (none || code > 0x10ffff) code = '_';
        int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
        static const unsigned first[4] = {0, 0xc0, 0xe0, 0xf0};
        kn_text_char(text, (char)(first[more] | code >> (6 * more)));
        while (more-- > 0) kn_text_char(text, (char)(0x80 | (code >> (6 * more) & 0x3f)));
    }
}
