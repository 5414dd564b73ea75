// SPDX-License-Identifier: Apache-2.0
// Words and numbers out of untrusted text.
#include "io/text_scan.h"
#include "kernel/context.h"

#include <limits.h>
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SHOWN_BYTES = 40,   // of a word, in a message
    NUMBER_BYTES = 1024 // of a number; more digits than any double needs (767 decide every rounding)
};

kn_scan kn_scan_start(kn_ctx *ctx, const char *name, const char *text, size_t bytes)
{
    return (kn_scan){.ctx = ctx, .name = name, .at = text, .end = text + bytes, .line = 1, .word = text};
}

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f';
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

bool kn_scan_at_end(kn_scan *scan)
{
    for (; scan->at < scan->end && is_space(*scan->at); scan->at++)
        if (*scan->at == '\n' && scan->line < INT_MAX) scan->line++;
    return scan->at == scan->end;
}

// Behind the bracket, the quoted text or the word at scan->at.
static void skip_bracketed(kn_scan *scan)
{
    if (*scan->at == '"') {
        for (scan->at++; scan->at < scan->end && *scan->at != '"'; scan->at++)
            if (*scan->at == '\n' && scan->line < INT_MAX) scan->line++;
        scan->at += scan->at < scan->end;
        return;
    }
    if (*scan->at == '[' || *scan->at == ']') {
        scan->at++;
        return;
    }
    while (scan->at < scan->end && !is_space(*scan->at) && *scan->at != '[' && *scan->at != ']') scan->at++;
}

bool kn_scan_word(kn_scan *scan)
{
    bool found = !kn_scan_at_end(scan);
    scan->word = scan->at;
    if (found && scan->brackets) skip_bracketed(scan);
    while (!scan->brackets && scan->at < scan->end && !is_space(*scan->at)) scan->at++;
    scan->length = (size_t)(scan->at - scan->word);
    return found;
}

kn_status kn_scan_fail(kn_scan *scan, kn_status status, const char *format, ...)
{
    char message[256];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    return kn_fail(scan->ctx, status, "%s:%d: %s", scan->name, scan->line, message);
}

kn_status kn_scan_fail_word(kn_scan *scan, const char *what, const char *problem)
{
    char shown[SHOWN_BYTES + 4] = "";
    size_t n = scan->length < SHOWN_BYTES ? scan->length : SHOWN_BYTES;
    for (size_t i = 0; i < n; i++) // bytes beyond ASCII could break a terminal
        shown[i] = scan->word[i] > ' ' && scan->word[i] < 127 ? scan->word[i] : '?';
    if (n < scan->length) memcpy(shown + n, "...", 4);
    return kn_scan_fail(scan, KN_EPARSE, "%s is %s: %s", what, problem, shown);
}

static kn_status fail_end(kn_scan *scan, const char *what)
{
    char item[32] = "", object[64] = "";
    if (scan->item > 0) snprintf(item, sizeof item, " %zu", scan->item);
    if (scan->object > 0) snprintf(object, sizeof object, " of %s %d", scan->kind, scan->object);
    return kn_scan_fail(scan, KN_EPARSE, "the file ends where %s%s%s was expected", what, item, object);
}

kn_status kn_scan_room(kn_scan *scan, double count, const char *what)
{
    double left = (double)(scan->end - scan->at);
    if (count <= (left + 1.0) / 2.0) return KN_OK;
    return kn_scan_fail(scan, KN_EPARSE, "%.0f numbers expected (%s), but only %.0f bytes follow", count, what, left);
}

kn_status kn_scan_int(kn_scan *scan, int *value, const char *what, int lo, int hi)
{
    if (!kn_scan_word(scan)) return fail_end(scan, what);
    const char *at = scan->word, *end = at + scan->length;
    bool negative = *at == '-';
    if (*at == '-' || *at == '+') at++;
    bool digits = at < end;
    long long magnitude = 0;
    for (; at < end && digits; at++) {
        digits = is_digit(*at);
        if (digits && magnitude <= INT_MAX) magnitude = 10 * magnitude + (*at - '0');
    }
    if (!digits) return kn_scan_fail_word(scan, what, "not an integer");
    long long result = negative ? -magnitude : magnitude;
    if (result < lo || result > hi) {
        char problem[64];
        snprintf(problem, sizeof problem, "not in %d .. %d", lo, hi);
        return kn_scan_fail_word(scan, what, problem);
    }
    *value = (int)result;
    return KN_OK;
}

// Where the longest [0-9]* from at ends; *found when it has a digit.
static const char *skip_digits(const char *at, const char *end, bool *found)
{
    for (; at < end && is_digit(*at); at++) *found = true;
    return at;
}

// [+-] digits [. digits] [e [+-] digits], at least one digit before the exponent. strtod alone would also take
// hexadecimal numbers, infinities and NaN. *point: the place of the decimal point, or end.
static bool is_number(const char *at, const char *end, const char **point)
{
    bool mantissa = false, exponent = false;
    *point = end;
    if (at < end && (*at == '+' || *at == '-')) at++;
    at = skip_digits(at, end, &mantissa);
    if (at < end && *at == '.') {
        *point = at;
        at = skip_digits(at + 1, end, &mantissa);
    }
    if (!mantissa) return false;
    if (at == end) return true;
    if (*at != 'e' && *at != 'E') return false;
    at++;
    if (at < end && (*at == '+' || *at == '-')) at++;
    return skip_digits(at, end, &exponent) == end && exponent;
}

// strtod reads the decimal point of the locale that the program has chosen, so it is given that one.
static double convert(const char *word, size_t length, const char *point)
{
    char copy[NUMBER_BYTES + 16];
    const char *local = localeconv()->decimal_point;
    size_t before = (size_t)(point - word), width = strlen(local);
    if (width > 8) local = ".", width = 1;
    memcpy(copy, word, before);
    if (before == length) {
        copy[before] = '\0';
    } else {
        memcpy(copy + before, local, width);
        memcpy(copy + before + width, point + 1, length - before - 1);
        copy[before + width + length - before - 1] = '\0';
    }
    return strtod(copy, NULL);
}

// "nan" and "inf" in any of the spellings that C writes: worth a message of its own.
static bool spells_nonfinite(const char *word, size_t length)
{
    static const char names[3][4] = {"nan", "inf", "ind"};
    if (length > 0 && (*word == '-' || *word == '+')) word++, length--;
    for (int k = 0; k < 3 && length >= 3; k++) {
        int same = 0;
        for (int i = 0; i < 3; i++) same += (word[i] | 0x20) == names[k][i];
        if (same == 3) return true;
    }
    return false;
}

kn_status kn_scan_real(kn_scan *scan, double *value, const char *what)
{
    if (!kn_scan_word(scan)) return fail_end(scan, what);
    const char *point;
    if (!is_number(scan->word, scan->word + scan->length, &point))
        return kn_scan_fail_word(scan, what,
                                 spells_nonfinite(scan->word, scan->length) ? "not finite" : "not a number");
    if (scan->length > NUMBER_BYTES) return kn_scan_fail_word(scan, what, "too long a number");
    double result = convert(scan->word, scan->length, point);
    if (!isfinite(result)) return kn_scan_fail_word(scan, what, "not finite");
    *value = result;
    return KN_OK;
}
