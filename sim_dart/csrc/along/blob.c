/* Opening a wide blob. What it is made from has been checked, all but the laws' own numbers are not looked
   at again: laws_check counts their states.                                                            */
#include "names.h"

#include "blob.h"

#include "../state.h"

#include <string.h>

/* Fields are padded to 8 bytes. */
static size_t padded(size_t bytes)
{
    return (bytes + 7u) & ~(size_t)7u;
}

size_t along_blob_size(const void *blob)
{
    const blob_header *h = blob;
    size_t size = sizeof *h;
#define ADD_SIZE(type, name, per_item, count)                                                          \
    size += padded(sizeof(type) * per_item * (size_t)h->counts.count);
    BLOB_FIELDS(ADD_SIZE)
#undef ADD_SIZE
    return size;
}

static const char *widen_int32_t(const char *from, char *to, size_t count)
{
    memcpy(to, from, count * sizeof(int32_t));
    return from + padded(count * sizeof(int32_t));
}

static const char *widen_real(const char *from, char *to, size_t count)
{
    const double *numbers = (const double *)(const void *)from;
    real *wide = (real *)(void *)to;
    for (size_t k = 0; k < count; k++) wide[k] = numbers[k];
    return from + count * sizeof *numbers;
}

void along_blob_widen(const void *blob, void *wide)
{
    const blob_header *h = blob;
    const char *from = (const char *)(h + 1);
    char *to = (char *)wide + sizeof *h;
    memcpy(wide, h, sizeof *h);
#define WIDEN(type, name, per_item, count)                                                             \
    from = widen_##type(from, to, per_item *(size_t)h->counts.count);                                  \
    to += padded(sizeof(type) * per_item * (size_t)h->counts.count);
    BLOB_FIELDS(WIDEN)
#undef WIDEN
}

int blob_open(blob_view *view, const void *blob, size_t size, char *message, size_t capacity)
{
    const blob_header *h = blob;
    const char *at = (const char *)(h + 1);
    (void)size;
    view->counts = h->counts;
#define SET_POINTER(type, name, per_item, count)                                                       \
    view->name = (const type *)(const void *)at;                                                       \
    at += padded(sizeof(type) * per_item * (size_t)h->counts.count);
    BLOB_FIELDS(SET_POINTER)
#undef SET_POINTER
    return laws_check(view, message, capacity);
}
