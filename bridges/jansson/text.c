// SPDX-License-Identifier: Apache-2.0
// kn_json_text: numbers, texts and arrays of them as one text.
#include "bridges/jansson/text.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBER_BYTES = 32 };

// What a number or a text is as a text; local holds it where it is none yet. NULL: neither.
static const char *scalar_text(const json_t *value, char local[NUMBER_BYTES])
{
    if (json_is_string(value)) return json_string_value(value);
    if (json_is_integer(value))
        snprintf(local, NUMBER_BYTES, "%lld", (long long)json_integer_value(value));
    else if (json_is_real(value))
        snprintf(local, NUMBER_BYTES, "%.17g", json_real_value(value));
    else
        return NULL;
    return local;
}

char *kn_json_text(const json_t *value)
{
    bool array = json_is_array(value);
    size_t n = array ? json_array_size(value) : 1, used = 0;
    char *out = calloc(1, 1), local[NUMBER_BYTES];
    for (size_t i = 0; i < n && out; i++) {
        const char *text = scalar_text(array ? json_array_get(value, i) : value, local);
        size_t length = text ? strlen(text) : 0;
        char *longer = text ? realloc(out, used + length + 2) : NULL;
        if (!longer) {
            free(out);
            return NULL;
        }
        out = longer;
        if (i > 0) out[used++] = ',';
        memcpy(out + used, text, length + 1);
        used += length;
    }
    return out;
}
