// SPDX-License-Identifier: Apache-2.0
// Lines of 80 columns: free parameters in the first 64 or 72, and what section and which line it is in the others.
#include "iges/write.h"

#include "io/decimal.h"

#include <stdio.h>
#include <string.h>

// Behind the parameters: a blank, seven columns for the entity, the section, seven for the line.
static const char blanks[KN_IGES_LINE_BYTES - KN_IGES_COLUMNS + 1] = "        P       \n";

static size_t used(const kn_text *text)
{
    return text->bytes - text->line;
}

static void fill(kn_text *text, size_t columns)
{
    static const char spaces[] = "                                                                                ";
    size_t n = used(text);
    if (n < columns) kn_text_bytes(text, spaces, columns - n);
}

static void end_line(kn_text *text)
{
    fill(text, KN_IGES_COLUMNS);
    kn_text_bytes(text, blanks, sizeof blanks - 1);
    text->line = text->bytes;
}

// A parameter with its comma stands in one line.
static void put_token(kn_text *text, const char *token, size_t bytes)
{
    if (used(text) + bytes > KN_IGES_COLUMNS) end_line(text);
    kn_text_bytes(text, token, bytes);
}

void kn_iges_put_integer(kn_text *text, uint64_t n)
{
    char token[KN_DECIMAL_BYTES + 1];
    size_t bytes = kn_decimal_integer(token, n);
    token[bytes++] = ',';
    put_token(text, token, bytes);
}

void kn_iges_put_real(kn_text *text, double x)
{
    if (x == 0.0 || x == 1.0) { // knots and weights: half of all
        put_token(text, x == 0.0 ? "0.," : "1.,", 3);
        return;
    }
    char token[KN_DECIMAL_BYTES + 1];
    size_t bytes = kn_decimal_iges(token, x);
    token[bytes++] = ',';
    put_token(text, token, bytes);
}

// "5Hknurl,": ASCII alone, a letter beyond it counts as one '_'.
static size_t hollerith(char *out, size_t room, const char *string)
{
    size_t n = 0;
    for (const char *s = string; *s; s++) n += (*s & 0xc0) != 0x80;
    size_t bytes = (size_t)snprintf(out, room, "%zuH", n);
    for (const char *s = string; *s && bytes + 1 < room; s++)
        if ((*s & 0xc0) != 0x80) out[bytes++] = (char)(*s >= 32 && *s < 127 ? *s : '_');
    out[bytes++] = ',';
    return bytes;
}

enum { STRING_BYTES = 1024 }; // longer ones are refused before

void kn_iges_put_string(kn_text *text, const char *string)
{
    char token[STRING_BYTES];
    size_t bytes = hollerith(token, sizeof token, string), at = 0;
    if (used(text) + 8 > KN_IGES_COLUMNS) end_line(text); // not in the middle of the count
    while (at < bytes && !text->failed) {
        size_t room = KN_IGES_COLUMNS - used(text), n = bytes - at < room ? bytes - at : room;
        if (n == 0) {
            end_line(text);
            continue;
        }
        kn_text_bytes(text, token + at, n);
        at += n;
    }
}

void kn_iges_end(kn_text *text)
{
    if (text->failed) return;
    text->data[text->bytes - 1] = ';';
    end_line(text);
}

void kn_iges_reopen(kn_text *text)
{
    if (text->failed) return;
    size_t line = text->bytes - KN_IGES_LINE_BYTES, n = KN_IGES_COLUMNS;
    while (text->data[line + n - 1] == ' ') n--;
    text->line = line, text->bytes = line + n;
    text->data[text->bytes - 1] = ',';
}

uint32_t kn_iges_count_lines(const kn_text *text, size_t begin)
{
    return (uint32_t)((text->bytes - begin) / KN_IGES_LINE_BYTES);
}

// ---- start and global sections ----

static void number_line(kn_text *text, char section, uint64_t *lines)
{
    char tail[16];
    fill(text, 72);
    int n = snprintf(tail, sizeof tail, "%c%7llu\n", section, (unsigned long long)++*lines);
    kn_text_bytes(text, tail, (size_t)n);
    text->line = text->bytes;
}

// Strings may be cut, and so may all others of the few that there are not be.
static void put_global(kn_text *text, const char *token, size_t bytes, uint64_t *lines)
{
    if (used(text) + bytes > 72 && used(text) + 8 > 72) number_line(text, 'G', lines);
    while (bytes > 0) {
        size_t room = 72 - used(text), n = bytes < room ? bytes : room;
        kn_text_bytes(text, token, n);
        token += n, bytes -= n;
        if (bytes > 0) number_line(text, 'G', lines);
    }
}

static void put_global_string(kn_text *text, const char *string, uint64_t *lines)
{
    char token[STRING_BYTES];
    put_global(text, token, hollerith(token, sizeof token, string), lines);
}

static void put_global_text(kn_text *text, const char *parameters, uint64_t *lines)
{
    if (used(text) + strlen(parameters) > 72) number_line(text, 'G', lines);
    kn_text_put(text, parameters);
}

// Integers of 32 bits; powers of ten and digits of single and double precision; scale 1; millimetres; version 5.3.
void kn_iges_put_start(kn_text *text, const char *product, const char *time_stamp, double uncertainty_mm,
                       uint64_t lines[2])
{
    char token[KN_DECIMAL_BYTES + 1];
    kn_text_put(text, "composed NURBS patches, knurl " KN_VERSION_STRING);
    number_line(text, 'S', &lines[0]);
    put_global_text(text, "1H,,1H;,", &lines[1]);
    put_global_string(text, product, &lines[1]);
    put_global_string(text, product, &lines[1]);
    put_global_string(text, "knurl", &lines[1]);
    put_global_string(text, "knurl " KN_VERSION_STRING, &lines[1]);
    put_global_text(text, "32,38,6,308,15,", &lines[1]);
    put_global_string(text, product, &lines[1]);
    put_global_text(text, "1.,2,2HMM,1,0.,", &lines[1]);
    put_global_string(text, time_stamp, &lines[1]);
    size_t bytes = kn_decimal_iges(token, uncertainty_mm);
    token[bytes++] = ',';
    put_global(text, token, bytes, &lines[1]);
    put_global_text(text, "0.,,,11,0,", &lines[1]);
    put_global_string(text, time_stamp, &lines[1]);
    if (!text->failed) text->data[text->bytes - 1] = ';';
    number_line(text, 'G', &lines[1]);
}
