// SPDX-License-Identifier: Apache-2.0
// What tests of the command line share: running it, and what it printed.
#ifndef TESTS_CLI_COMMAND_H
#define TESTS_CLI_COMMAND_H

#include "tests/support/support.h"

#include <jansson.h>

enum { PATH_BYTES = TEST_PATH_BYTES, TEXT_BYTES = 1 << 16 };

// What the last command printed to standard output and standard error.
extern char printed[TEXT_BYTES], complained[TEXT_BYTES];

// Runs the command with these arguments (shell words) and answers its exit code.
int run(const char *format, ...) KN_PRINTF(1, 2);
// What it printed as JSON, for json_decref; the test fails when it is none.
json_t *printed_json(void);

void slurp(const char *path, char text[TEXT_BYTES]);
void write_text(const char *path, const char *text);
bool exists(const char *path);

// Writes a spline to path as .g2.
void write_g2(const char *path, const kn_spline *s);

#endif
