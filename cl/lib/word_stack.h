/**
 * @file
 * A stack of child words in private memory:
 *
 *     stack_begin(entries, bottom)          puts one word on it
 *     stack_push(entries, &top, word, does) pushes a word, if it does
 *     stack_pop(entries, &top, word, does)  pops one, if it does; else that is the word given
 *
 * Left to itself, NVIDIA's compiler keeps a place for each entry that may or may not be pushed: 16
 * of the 163 instructions that a quad node took.
 */
#ifndef LIB_WORD_STACK_H
#define LIB_WORD_STACK_H

#include "lib/warp.h"

#if WARP_VOTES

typedef uint stack_top; // address of the last entry, in the warp's local space

static inline stack_top stack_begin(int *entries, const int bottom)
{
    stack_top top;
    __asm volatile("{ .reg .u64 a; cvta.to.local.u64 a, %1; cvt.u32.u64 %0, a;"
                   " st.local.s32 [%0], %2; }"
                   : "=r"(top)
                   : "l"((ulong)entries), "r"(bottom));
    return top;
}

static inline void stack_push(int *entries, stack_top *top, const int word, const bool does)
{
    __asm volatile("{ .reg .pred p; setp.ne.u32 p, %2, 0;"
                   " @p st.local.s32 [%0 + 4], %1; @p add.u32 %0, %0, 4; }"
                   : "+r"(*top)
                   : "r"(word), "r"((uint)does));
}

static inline int stack_pop(const int *entries, stack_top *top, const int word, const bool does)
{
    int popped = word;
    __asm volatile("{ .reg .pred p; setp.ne.u32 p, %2, 0;"
                   " @p ld.local.s32 %0, [%1]; @p add.u32 %1, %1, -4; }"
                   : "+r"(popped), "+r"(*top)
                   : "r"((uint)does));
    return popped;
}

#else

typedef int stack_top; // index of the last entry

static inline stack_top stack_begin(int *entries, const int bottom)
{
    entries[0] = bottom;
    return 0;
}

static inline void stack_push(int *entries, stack_top *top, const int word, const bool does)
{
    if (does)
        entries[++*top] = word;
}

static inline int stack_pop(const int *entries, stack_top *top, const int word, const bool does)
{
    return does ? entries[(*top)--] : word;
}

#endif

#endif
