/**
 * @file
 * An arena: many allocations that die at once.
 */
#ifndef CORE_ARENA_H
#define CORE_ARENA_H

#include <stdbool.h>
#include <stddef.h>

/** All zero is a valid empty arena. */
struct arena {
    struct arena_block *blocks; // newest first; owned
    struct arena_guest *guests; // what was adopted, newest first; owned
    size_t total_size;          // bytes handed out or adopted
};

/**
 * Allocates zeroed memory, aligned for any type, that lives until arena_free().
 *
 * @param count, size  Elements and bytes of each; the product is checked for overflow. 0 elements
 * give a valid pointer.
 * @return NULL if there is not enough memory.
 */
void *arena_alloc(struct arena *arena, size_t count, size_t size);

/** Copies a string into the arena. NULL if there is not enough memory. */
char *arena_strdup(struct arena *arena, const char *text);

/**
 * Takes memory over that is to be released with free(): it lives until arena_free(), and is not
 * copied.
 *
 * @param size  Its bytes.
 * @return false, and the caller still owns it, if there is not enough memory.
 */
bool arena_adopt(struct arena *arena, void *memory, size_t size);

/** Releases everything and leaves the arena empty. */
void arena_free(struct arena *arena);

#endif
