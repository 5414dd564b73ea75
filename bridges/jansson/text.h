// SPDX-License-Identifier: Apache-2.0
// JSON values as texts, in the words of command-line options.
#ifndef BRIDGES_JANSSON_TEXT_H
#define BRIDGES_JANSSON_TEXT_H

#include <jansson.h>

// A number or a text as a text, an array of them separated by commas; numbers have all their digits. From malloc;
// NULL: something else, or no memory.
char *kn_json_text(const json_t *value);

#endif
