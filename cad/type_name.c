// SPDX-License-Identifier: Apache-2.0
#include <knurl/cad.h>

const char *kn_cad_type_name(kn_cad_type type)
{
    static const char *const names[KN_CAD_TYPES] = {
        [KN_CAD_PLANE] = "plane",           [KN_CAD_CYLINDER] = "cylinder", [KN_CAD_CONE] = "cone",
        [KN_CAD_SPHERE] = "sphere",         [KN_CAD_TORUS] = "torus",       [KN_CAD_EXTRUSION] = "extrusion",
        [KN_CAD_REVOLUTION] = "revolution", [KN_CAD_BEZIER] = "bezier",     [KN_CAD_BSPLINE] = "bspline",
        [KN_CAD_OFFSET] = "offset",         [KN_CAD_OTHER] = "other",
    };
    return (unsigned)type < KN_CAD_TYPES ? names[type] : NULL;
}
