// SPDX-License-Identifier: Apache-2.0
// A document of OCCT as a kn_cad.
#ifndef BRIDGES_OCCT_CAD_MODEL_HPP
#define BRIDGES_OCCT_CAD_MODEL_HPP

#include <knurl/cad.h>

#include "bridges/occt/document.hpp"

namespace kn_occt
{

// out: empty; face i is d->faces[i], body i d->bodies[i]: what cannot be converted is taken out of d, with a warning
// to the log. Throws failed, std::bad_alloc, and what OCCT throws; out is then whatever it is: clear it.
void model_of(kn_ctx *ctx, kn_cad *out, document *d, const char *path);

} // namespace kn_occt

#endif
