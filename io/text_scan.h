// SPDX-License-Identifier: Apache-2.0
// Inside io: words and numbers out of untrusted text, with line numbers for messages.
#ifndef IO_TEXT_SCAN_H
#define IO_TEXT_SCAN_H

#include <knurl/base.h>

// A place in text of which no byte at or beyond end is ever looked at. Words are separated by white space. What a
// scan call fails with is KN_EPARSE, "name:line: what ...". When the text ends too early the message also says which
// item of which object was expected: the reader keeps those two up to date.
typedef struct kn_scan {
    kn_ctx *ctx;
    const char *name;
    const char *at, *end;
    int line;
    const char *word; // the last word read: not ended by a zero byte
    size_t length;
    const char *kind; // of object: "patch"
    int object;       // counted from 1, 0: none
    size_t item;      // counted from 1, 0: none
    bool brackets;    // '[' and ']' are words of their own, and "..." is one with the quotes
} kn_scan;

kn_scan kn_scan_start(kn_ctx *ctx, const char *name, const char *text, size_t bytes);
// Goes to the next word and reads it; false at the end of the text.
bool kn_scan_word(kn_scan *scan);
// True when nothing but white space is left; reads no word.
bool kn_scan_at_end(kn_scan *scan);
// An integer in [lo,hi].
KN_CHECKED kn_status kn_scan_int(kn_scan *scan, int *value, const char *what, int lo, int hi);
// A finite decimal number, correctly rounded whatever the locale is.
KN_CHECKED kn_status kn_scan_real(kn_scan *scan, double *value, const char *what);
// KN_OK when `count` numbers, at least a byte and a separator each, can still follow: asked before allocating.
KN_CHECKED kn_status kn_scan_room(kn_scan *scan, double count, const char *what);
// "name:line: " and the message; the line is that of the last word.
kn_status kn_scan_fail(kn_scan *scan, kn_status status, const char *format, ...) KN_PRINTF(3, 4);
// "what is PROBLEM: the last word".
kn_status kn_scan_fail_word(kn_scan *scan, const char *what, const char *problem);

#endif
