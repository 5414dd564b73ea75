// SPDX-License-Identifier: Apache-2.0
// knurl-cad, what knurl runs for what Open CASCADE does: a broken file can crash or hang this program alone.
#ifndef BRIDGES_OCCT_PROGRAM_H
#define BRIDGES_OCCT_PROGRAM_H

#include <knurl/base.h>

// Its exit codes, those of knurl: all went well; the system, memory; a wrong call; a bad file.
enum { KN_CAD_OK = 0, KN_CAD_FAILED = 1, KN_CAD_USAGE = 2, KN_CAD_BAD_INPUT = 3 };

// One of its commands: argv[0] is its name. Prints the context's error and answers the exit code.
int kn_cad_command_read(kn_ctx *ctx, int argc, char **argv);
int kn_cad_command_host(kn_ctx *ctx, int argc, char **argv);
int kn_cad_fail(kn_ctx *ctx, kn_status status);

#endif
