// SPDX-License-Identifier: Apache-2.0
// Inside io: text that grows while it is formatted.
#ifndef IO_TEXT_BUFFER_H
#define IO_TEXT_BUFFER_H

#include <knurl/base.h>

// A zero-initialised buffer is empty; `ctx` is set by the caller. Without memory it keeps what it has and remembers
// the failure, so that a formatter looks at `failed` once, at its end.
typedef struct kn_text {
    kn_ctx *ctx;
    char *data;
    size_t bytes, room;
    size_t line; // where the current line starts, for wrapping
    bool failed;
} kn_text;

void kn_text_clear(kn_text *text);
// Gives back the room that is left: for a text that waits. fails: KN_ENOMEM, now or before.
KN_CHECKED kn_status kn_text_fit(kn_text *text);
void kn_text_put(kn_text *text, const char *string);
void kn_text_bytes(kn_text *text, const void *data, size_t bytes);
void kn_text_char(kn_text *text, char c);
void kn_text_integer(kn_text *text, uint64_t n);
// "#n", a reference in a STEP file.
void kn_text_reference(kn_text *text, uint64_t n);
// A reference to a number that is not known yet: to be counted from the base that kn_text_expand is told.
void kn_text_relative(kn_text *text, uint32_t offset);
// Appends bytes of a text, its relative references as "#base+offset".
void kn_text_expand(kn_text *text, const char *data, size_t bytes, uint64_t base);
// As kn_decimal_step and kn_decimal_plain.
void kn_text_step_real(kn_text *text, double x);
void kn_text_plain_real(kn_text *text, double x, int significant);
void kn_text_newline(kn_text *text);
// A comma, and a new line when the current one has become long.
void kn_text_comma(kn_text *text);
// A STEP string with its quotes: a quote and a backslash doubled, UTF-8 as \X2\ sequences, control characters as \X\.
void kn_text_step_string(kn_text *text, const char *string);
// As UTF-8 that readers of XML take: bytes of a string that is none count as Latin-1, control characters are '_'.
void kn_text_utf8(kn_text *text, const char *string);

#endif
