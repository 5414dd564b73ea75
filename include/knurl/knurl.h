// SPDX-License-Identifier: Apache-2.0
// The whole public interface of libknurl.
#ifndef KNURL_H
#define KNURL_H

#include <knurl/base.h>
#include <knurl/bezier.h>
#include <knurl/spline.h>
#include <knurl/fit.h>
#include <knurl/construct.h>
#include <knurl/solve.h>
#include <knurl/shell.h>
#include <knurl/cells.h>
#include <knurl/trim.h>
#include <knurl/mesh.h>
#include <knurl/fold.h>
#include <knurl/field.h>
#include <knurl/tile.h>
#include <knurl/compose.h>
#include <knurl/job.h>
#include <knurl/slice.h>
#include <knurl/io.h>
#include <knurl/cad.h>
#include <knurl/iges.h>
#include <knurl/step.h>
#include <knurl/write.h>

#endif
