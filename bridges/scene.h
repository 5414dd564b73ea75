// SPDX-License-Identifier: Apache-2.0
// kn_scene: triangle meshes with a material each, what mesh readers fill and the renderer consumes.
#ifndef BRIDGES_SCENE_H
#define BRIDGES_SCENE_H

#include <knurl/job.h>
#include <knurl/mesh.h>

// mesh.normal may be NULL: the triangles are then flat. color, when there is one, is multiplied with the material's.
typedef struct kn_scene_item {
    kn_mesh mesh;
    kn_material material;
    float *color; // linear RGB in [0,1], 3 numbers a vertex; NULL: none. Owned, as the mesh is
} kn_scene_item;

// A zero-initialised kn_scene is a valid empty one. The items belong to it.
typedef struct kn_scene {
    kn_scene_item *items;
    int nitems;
} kn_scene;

static inline void kn_scene_item_clear(kn_ctx *ctx, kn_scene_item *item)
{
    kn_mesh_clear(ctx, &item->mesh);
    kn_free(ctx, item->color);
    item->color = NULL;
}

static inline void kn_scene_clear(kn_ctx *ctx, kn_scene *scene)
{
    for (int i = 0; i < scene->nitems; i++) kn_scene_item_clear(ctx, &scene->items[i]);
    kn_free(ctx, scene->items);
    scene->items = NULL, scene->nitems = 0;
}

#endif
