// SPDX-License-Identifier: Apache-2.0
// Morphs of two meshes while allocations fail.
#ifndef TESTS_MESH_STARVED_H
#define TESTS_MESH_STARVED_H

#include <knurl/mesh.h>

// test_allocation_failures of kn_mesh_morph from a to b.
void starved_morph(const kn_mesh *a, const kn_mesh *b);

#endif
