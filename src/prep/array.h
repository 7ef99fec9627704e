/**
 * @file
 * Arrays of the host's preparation: allocation that is never NULL for no elements.
 */
#ifndef PREP_ARRAY_H
#define PREP_ARRAY_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/**
 * Allocates `count` elements of `size` bytes, not cleared; release with free().
 *
 * @return NULL if there is not enough memory or the product overflows; a valid pointer for count 0.
 */
static inline void *array_alloc(size_t count, size_t size)
{
    if (count == 0)
        count = 1;
    return count <= SIZE_MAX / size ? malloc(count * size) : NULL;
}

#endif
