// What the device takes the shared structs to be.

#include "layout_list.h"
#include "test.h"

// Offset and size of a struct or of a member.
#define WRITE_STRUCT(name)                                                                         \
    out[n++] = 0;                                                                                  \
    out[n++] = sizeof(struct name);
#define WRITE_MEMBER(name, member)                                                                 \
    {                                                                                              \
        struct name s;                                                                             \
        out[n++] = (uint)((char *)&s.member - (char *)&s);                                         \
        out[n++] = sizeof(s.member);                                                               \
    }

// out[2 i]: offset of entry i of LAYOUT_LIST; out[2 i + 1]: its size, bytes.
TEST_KERNEL layout_write(__global uint *out)
{
    if (get_global_id(0) > 0)
        return;
    uint n = 0;
    LAYOUT_LIST(WRITE_STRUCT, WRITE_MEMBER)
}
