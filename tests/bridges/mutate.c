// SPDX-License-Identifier: Apache-2.0
#include "tests/bridges/mutate.h"

#include <string.h>

typedef struct text {
    char *at;
    size_t n, room;
    bool columns; // lines of 80, of which the last 16 number them
    test_rng *rng;
} text;

static size_t place(const text *t)
{
    return t->n > 0 ? (size_t)(test_bits(t->rng) % t->n) : 0;
}

static size_t below(const text *t, size_t n)
{
    return (size_t)(test_bits(t->rng) % n);
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_letter(char c)
{
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
}

static bool is_token(char c)
{
    return is_digit(c) || is_letter(c) || c == '.' || c == '-' || c == '+' || c == '#';
}

// m bytes in the place of those in [a, b). In columns the rest of the data, to column 64, moves and is cut or filled up.
static void splice(text *t, size_t a, size_t b, const char *with, size_t m)
{
    size_t end = a;
    if (t->columns && below(t, 8) > 0) {
        while (end > 0 && t->at[end - 1] != '\n') end--; // where the line begins
        end += 64;
    }
    if (end > b && end <= t->n && memchr(t->at + a, '\n', end - a) == NULL) {
        if (a + m > end) m = end - a;
        size_t rest = end - b < end - a - m ? end - b : end - a - m;
        memmove(t->at + a + m, t->at + b, rest);
        memset(t->at + a + m + rest, ' ', end - a - m - rest);
    } else {
        if (t->n - (b - a) + m > t->room) return;
        memmove(t->at + a + m, t->at + b, t->n - b);
        t->n = t->n - (b - a) + m;
    }
    memcpy(t->at + a, with, m);
}

// A token near a random place: [*a, *b). With a '#' in front it is a reference.
static bool token(const text *t, size_t *a, size_t *b)
{
    size_t at = place(t);
    while (at < t->n && is_token(t->at[at])) at++; // not from its middle
    while (at < t->n && !is_token(t->at[at])) at++;
    *a = at;
    while (at < t->n && is_token(t->at[at])) at++;
    *b = at;
    return *b > *a;
}

static void some_bytes(text *t)
{
    static const char letters[] = "#0123456789().,;'$*E+- \nABCDEFGHIJKLMNOPQRSTUVWXYZ\377\0";
    for (size_t i = 1 + below(t, 4); i > 0; i--) t->at[place(t)] = letters[below(t, sizeof letters)];
}

static void one_bit(text *t)
{
    size_t at = place(t);
    t->at[at] = (char)(t->at[at] ^ (1 << below(t, 8)));
}

static void renumber(text *t)
{
    static const char *const numbers[] = {"0",       "-1",     "1.E308",   "99999999",   "0.",          "-0.",
                                          "1.E-300", "1",      "17",       ".T.",        "$",           "NaN",
                                          "INF",     "1.E999", "-1.E999",  "2147483647", "-2147483648", "4294967296",
                                          "1.E-7",   "1.E5",   "1.000001", "3",          "255",         "1000000"};
    const char *number = numbers[below(t, sizeof numbers / sizeof *numbers)];
    size_t a = place(t), b;
    while (a < t->n && !is_digit(t->at[a])) a++;
    if (a == t->n) return;
    for (b = a; b < t->n && (is_digit(t->at[b]) || t->at[b] == '.');) b++;
    splice(t, a, b, number, strlen(number));
}

// Digits of a number, as many as there were.
static void redigit(text *t)
{
    size_t at = place(t);
    while (at < t->n && !is_digit(t->at[at])) at++;
    for (; at < t->n && is_digit(t->at[at]); at++)
        if (below(t, 2) == 0) t->at[at] = (char)('0' + below(t, 10));
}

// A token becomes another one of the text; one of its kind, mostly.
static void retoken(text *t)
{
    char copy[80];
    size_t a, b, c = 0, d = 0;
    if (!token(t, &a, &b)) return;
    bool any = below(t, 6) == 0, found = false;
    for (int i = 0; i < 8 && !found; i++)
        found = token(t, &c, &d) &&
                (any || (is_letter(t->at[a]) == is_letter(t->at[c]) && (t->at[a] == '#') == (t->at[c] == '#')));
    if (!found || d - c > sizeof copy) return;
    memcpy(copy, t->at + c, d - c);
    splice(t, a, b, copy, d - c);
}

// A reference of STEP becomes another; in columns a field of eight becomes another of the text.
static void refer(text *t)
{
    char copy[16];
    size_t a = place(t), b = place(t), m = 8;
    if (t->columns) {
        a -= a % 81 % 8, b -= b % 81 % 8;
        if (a + m > t->n || b + m > t->n) return;
        memcpy(copy, t->at + b, m);
        memcpy(t->at + a, copy, m);
        return;
    }
    while (a < t->n && !(t->at[a] == '#' && a > 0 && t->at[a - 1] != '\n')) a++;
    while (b < t->n && t->at[b] != '#') b++;
    if (a >= t->n || b >= t->n) return;
    size_t c = a + 1, d = b + 1;
    while (c < t->n && is_digit(t->at[c])) c++;
    while (d < t->n && is_digit(t->at[d]) && d - b < sizeof copy) d++;
    memcpy(copy, t->at + b, d - b);
    splice(t, a, c, copy, d - b);
}

// [*a, *b): the line around a random place, its end included.
static void line(const text *t, size_t *a, size_t *b)
{
    *a = *b = place(t);
    while (*a > 0 && t->at[*a - 1] != '\n') (*a)--;
    while (*b < t->n && t->at[*b] != '\n') (*b)++;
    if (*b < t->n) (*b)++;
}

// One or several lines less, twice, or many times.
static void lines(text *t)
{
    size_t a, b, c, d;
    line(t, &a, &b);
    line(t, &c, &d);
    size_t much = b - a, times = below(t, 12) == 0 ? 1 + below(t, 200) : 1;
    if (below(t, 2) == 0) {
        if (below(t, 4) == 0 && a < d && d - a < 2000) b = d; // all between them
        memmove(t->at + a, t->at + b, t->n - b);
        t->n -= b - a;
        return;
    }
    for (; times > 0 && t->n + much <= t->room; times--) {
        memmove(t->at + c + much, t->at + c, t->n - c);
        if (a >= c) a += much;
        memmove(t->at + c, t->at + a, much);
        t->n += much;
    }
}

// A piece less, twice, or in another's place.
static void pieces(text *t)
{
    char chunk[256], other[256];
    size_t a = place(t), b = place(t), m = 1 + below(t, sizeof chunk - 1);
    if (a + m > t->n || b + m > t->n) return;
    memcpy(chunk, t->at + a, m);
    switch (below(t, 3)) {
    case 0: splice(t, a, a + m, "", 0); return;
    case 1: splice(t, b, b, chunk, m); return;
    default:
        memcpy(other, t->at + b, m);
        if (a < b + m && b < a + m) return;
        memcpy(t->at + a, other, m);
        memcpy(t->at + b, chunk, m);
    }
}

// Cut off: with the last lines behind it, or without.
static void shorten(text *t)
{
    size_t a = place(t), tail = t->columns ? 81 : 26;
    if (below(t, 4) == 0) {
        t->n = a;
    } else if (t->n > 2 * tail && a + tail < t->n) {
        memmove(t->at + a, t->at + t->n - tail, tail);
        t->n = a + tail;
    }
}

size_t test_mutate(test_rng *rng, char *bytes, size_t n, size_t room)
{
    text t = {bytes, n, room, n > 82 && bytes[72] == 'S' && bytes[80] == '\n', rng};
    size_t changes = below(&t, 10) == 0 ? 1 + below(&t, 30) : 1 + below(&t, 3);
    for (; changes > 0 && t.n > 0; changes--) {
        switch (below(&t, 20)) {
        case 0: some_bytes(&t); break;
        case 1: one_bit(&t); break;
        case 2: pieces(&t); break;
        case 3:
            if (below(&t, 3) == 0) shorten(&t);
            break;
        case 4:
        case 5: lines(&t); break;
        case 6:
        case 7: redigit(&t); break;
        case 8:
        case 9:
        case 10:
        case 11: retoken(&t); break;
        case 12:
        case 13:
        case 14: refer(&t); break;
        default: renumber(&t);
        }
    }
    return t.n;
}
