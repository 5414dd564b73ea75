// SPDX-License-Identifier: Apache-2.0
// A curve of a STEP file by itself.
#include "step/line.h"
#include "kernel/context.h"

kn_status kn_step_put_curve(kn_text *text, kn_step_item *item, const kn_patch *patch, double mm)
{
    kn_patch_curve line = {0};
    kn_spline s = kn_patch_spline(patch);
    kn_mark mark = kn_scratch_mark(text->ctx);
    kn_status status = kn_patch_curve_load(text->ctx, &line, &s, 0, mm, "STEP");
    if (status == KN_OK) {
        uint32_t n = (uint32_t)line.axis.n;
        line.first = 0, line.by = 1;
        kn_step_put_line_points(text, &line, 3);
        kn_step_put_relative(text, n);
        kn_step_put_line(text, &line, false, false);
        *item = (kn_step_item){.kind = KN_STEP_CURVE, .look = patch->look, .id = patch->id, .text_end = text->bytes};
        item->numbers = n + 1, item->main = n;
    }
    kn_scratch_release(text->ctx, mark);
    return status == KN_OK && text->failed ? KN_ENOMEM : status;
}
