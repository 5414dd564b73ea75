// SPDX-License-Identifier: Apache-2.0
// Inside io: one way to say what the system refused.
#ifndef IO_IO_ERROR_H
#define IO_IO_ERROR_H

#include <knurl/base.h>

// Records "path: what: reason" with the system's own words for error_number (an errno; 0: no reason known).
// Answers KN_EIO.
kn_status kn_fail_io(kn_ctx *ctx, const char *path, const char *what, int error_number);

#endif
