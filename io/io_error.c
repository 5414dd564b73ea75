// SPDX-License-Identifier: Apache-2.0
// The system's reason for a failed read or write, as a message.
#include "io/io_error.h"
#include "kernel/context.h"

#include <string.h>

kn_status kn_fail_io(kn_ctx *ctx, const char *path, const char *what, int error_number)
{
    char reason[128];
    if (error_number == 0) return kn_fail(ctx, KN_EIO, "%s: %s", path, what);
    if (strerror_r(error_number, reason, sizeof reason) != 0)
        return kn_fail(ctx, KN_EIO, "%s: %s: error %d", path, what, error_number);
    return kn_fail(ctx, KN_EIO, "%s: %s: %s", path, what, reason);
}
