#include "core/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// Small allocations share blocks of this many bytes; larger ones get a block of their own, so that
// the waste stays below one small block.
#define ARENA_BLOCK_SIZE ((size_t)64 * 1024)
#define ARENA_ALIGNMENT  _Alignof(max_align_t)

struct arena_block {
    struct arena_block *next; // older block, or NULL
    size_t used;              // bytes of `data` handed out
    size_t capacity;          // bytes of `data`
    _Alignas(max_align_t) unsigned char data[];
};

// Stands in a block.
struct arena_guest {
    struct arena_guest *next; // older, or NULL
    void *memory;             // owned
};

// Adds a zeroed block with room for `capacity` bytes in front of the list.
static struct arena_block *add_block(struct arena *arena, size_t capacity)
{
    if (capacity > SIZE_MAX - sizeof(struct arena_block))
        return NULL;
    struct arena_block *block = calloc(1, sizeof(struct arena_block) + capacity);
    if (block == NULL)
        return NULL;
    block->capacity = capacity;
    block->next = arena->blocks;
    arena->blocks = block;
    return block;
}

void *arena_alloc(struct arena *arena, size_t count, size_t size)
{
    if (size != 0 && count > (SIZE_MAX - ARENA_ALIGNMENT) / size)
        return NULL;
    size_t bytes = count * size;
    bytes = bytes == 0 ? ARENA_ALIGNMENT
                       : (bytes + ARENA_ALIGNMENT - 1) / ARENA_ALIGNMENT * ARENA_ALIGNMENT;

    struct arena_block *block = arena->blocks;
    if (block == NULL || block->capacity - block->used < bytes) {
        if (bytes >= ARENA_BLOCK_SIZE / 4) {
            // A block of its own, filed behind the newest so that the latter is filled further.
            struct arena_block *newest = arena->blocks;
            block = add_block(arena, bytes);
            if (block != NULL && newest != NULL) {
                block->next = newest->next;
                newest->next = block;
                arena->blocks = newest;
            }
        } else {
            block = add_block(arena, ARENA_BLOCK_SIZE);
        }
        if (block == NULL)
            return NULL;
    }
    void *memory = block->data + block->used;
    block->used += bytes;
    arena->total_size += bytes;
    return memory;
}

char *arena_strdup(struct arena *arena, const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = arena_alloc(arena, size, 1);
    if (copy != NULL)
        memcpy(copy, text, size);
    return copy;
}

bool arena_adopt(struct arena *arena, void *memory, size_t size)
{
    struct arena_guest *guest = arena_alloc(arena, 1, sizeof(*guest));
    if (guest == NULL)
        return false;
    *guest = (struct arena_guest){arena->guests, memory};
    arena->guests = guest;
    arena->total_size += size;
    return true;
}

void arena_free(struct arena *arena)
{
    for (struct arena_guest *guest = arena->guests; guest != NULL; guest = guest->next)
        free(guest->memory);
    struct arena_block *block = arena->blocks;
    while (block != NULL) {
        struct arena_block *next = block->next;
        free(block);
        block = next;
    }
    *arena = (struct arena){0};
}
