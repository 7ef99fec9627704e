// lib/traverse.h asked for any hit, one ray an item.

#include "lib/traverse.h"
#include "test.h"

TEST_KERNEL any_hit(TRACED_PARAMETERS, __global const struct ray *restrict rays,
                    __global struct hit *restrict hits, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    TRACED_SCENE(scene);
    hits[i] = traverse(nodes, &scene, rays[i].org.xyz, rays[i].dir.xyz, rays[i].org.w,
                       rays[i].dir.w, true);
}
