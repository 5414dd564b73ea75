// SPDX-License-Identifier: Apache-2.0
// Texts of STEP, IGES and BREP with something wrong in them.
#ifndef TESTS_BRIDGES_MUTATE_H
#define TESTS_BRIDGES_MUTATE_H

#include "tests/support/support.h"

// Changes a text of n bytes in place, `room` of them at most, and answers how many there are then: bytes, numbers (NaN,
// 1e999, counts beyond all sense), references and other tokens exchanged, lines and pieces left out, repeated, moved, the
// end in the middle. Of texts in columns (IGES) what goes in or out leaves columns 65 to 80 where they are, mostly.
size_t test_mutate(test_rng *rng, char *bytes, size_t n, size_t room);

#endif
