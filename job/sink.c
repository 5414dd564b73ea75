// SPDX-License-Identifier: Apache-2.0
// The end of a sink.
#include <knurl/job.h>

void kn_sink_close(kn_ctx *ctx, kn_sink *sink)
{
    if (!sink) return;
    if (sink->close) sink->close(ctx, sink->user);
    *sink = (kn_sink){0};
}
