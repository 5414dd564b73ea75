// SPDX-License-Identifier: Apache-2.0
// One curve of a STEP file on its own control points.
#include "step/face.h"
#include "kernel/context.h"

#include <math.h>

static kn_status put_points(kn_text *text, const kn_bezier *b, double mm, bool *rational)
{
    size_t n = kn_bezier_count(b);
    *rational = false;
    for (size_t k = 0; k < n; k++) {
        double weight = b->rational ? b->coef[3 * n + k] : 1.0;
        *rational = *rational || (b->rational && weight != b->coef[3 * n]);
        kn_step_put_relative(text, (uint32_t)k);
        kn_text_put(text, "CARTESIAN_POINT('',(");
        for (size_t c = 0; c < 3; c++) {
            double x = b->coef[c * n + k] / weight * mm;
            if (!(weight > 0.0) || !isfinite(x) || !isfinite(weight))
                return kn_fail(text->ctx, KN_EUNDEFINED, "STEP: a control point of a curve is not finite");
            if (c > 0) kn_text_char(text, ',');
            kn_text_step_real(text, x);
        }
        kn_text_put(text, "));");
        kn_text_newline(text);
    }
    return KN_OK;
}

static void put_multiplicity(kn_text *text, uint64_t n)
{
    kn_text_char(text, '(');
    kn_text_integer(text, n);
    kn_text_char(text, ',');
    kn_text_integer(text, n);
    kn_text_put(text, "),(0.,1.),.UNSPECIFIED.");
}

kn_status kn_step_put_curve(kn_text *text, kn_step_item *item, const kn_patch *patch, double mm)
{
    const kn_bezier *b = &patch->bezier;
    uint64_t n = kn_bezier_count(b);
    bool rational;
    kn_status status = put_points(text, b, mm, &rational);
    if (status != KN_OK) return status;
    kn_step_put_relative(text, (uint32_t)n);
    kn_text_put(text, rational ? "(BOUNDED_CURVE()B_SPLINE_CURVE(" : "B_SPLINE_CURVE_WITH_KNOTS('',");
    kn_text_integer(text, n - 1);
    kn_text_put(text, ",(");
    for (uint64_t k = 0; k < n; k++) {
        if (k > 0) kn_text_comma(text);
        kn_text_relative(text, (uint32_t)k);
    }
    kn_text_put(text, rational ? "),.UNSPECIFIED.,.F.,.F.)B_SPLINE_CURVE_WITH_KNOTS(" : "),.UNSPECIFIED.,.F.,.F.,");
    put_multiplicity(text, n);
    if (rational) {
        kn_text_char(text, ')');
        kn_text_newline(text);
        kn_text_put(text, "CURVE()GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE((");
        for (uint64_t k = 0; k < n; k++) {
            if (k > 0) kn_text_comma(text);
            kn_text_step_real(text, b->coef[3 * n + k]);
        }
        kn_text_put(text, "))REPRESENTATION_ITEM('')");
    }
    kn_text_put(text, ");");
    kn_text_newline(text);
    *item = (kn_step_item){.kind = KN_STEP_CURVE, .look = patch->look, .id = patch->id, .text_end = text->bytes};
    item->numbers = (uint32_t)n + 1, item->main = (uint32_t)n;
    return text->failed ? KN_ENOMEM : KN_OK;
}
