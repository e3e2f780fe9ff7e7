/* Open a robot blob. Every number in the blob is checked, since the blob may be damaged. */
#include "blob.h"

#include "../core.h"
#include "../named_arrays.h"
#include "../../generated/law_parameters.h"
#include "checks/check_cable_friction.h"
#include "checks/check_parts.h"
#include "checks/check_paths.h"
#include "checks/check_robot.h"
#include "layout_hash.h"
#include "message.h"

#define LAYOUT_COUNT(name, largest) "count " #name "\n"
#define LAYOUT_FIELD(type, name, per_item, count) #type " " #name " " #per_item " " #count "\n"

const char *core_layout(void)
{
    return BLOB_COUNTS(LAYOUT_COUNT) BLOB_FIELDS(LAYOUT_FIELD);
}

const char *core_laws(void)
{
    return LAW_NAMES;
}

uint32_t core_layout_hash(void)
{
    return layout_hash_on(layout_hash(core_layout()), core_laws());
}

uint32_t core_version(void)
{
    return BLOB_VERSION;
}

static size_t expected_size(const blob_counts *n)
{
    size_t size = sizeof(blob_header);
#define ADD_SIZE(type, name, per_item, count) size += padded(sizeof(type) * per_item * (size_t)n->count);
    BLOB_FIELDS(ADD_SIZE)
#undef ADD_SIZE
    return size;
}

static int check_header(const blob_header *h, size_t size, char *message, size_t capacity)
{
    if (h->magic == PRECISE(BLOB_MAGIC_FLOAT, BLOB_MAGIC_DOUBLE))
        return reject(message, capacity, "the blob has " PRECISE("single", "double")
                      " precision, this library " PRECISE("double", "single"));
    if (h->magic != BLOB_MAGIC) return reject(message, capacity, "this is not a robot blob");
    if (h->version != BLOB_VERSION || h->layout_hash != core_layout_hash())
        return reject(message, capacity, "the blob has version %u, this library version %u",
                      (unsigned)h->version, BLOB_VERSION);
#define CHECK_COUNT(name, largest)                                                                     \
    if (h->counts.name < 0 || h->counts.name > largest)                                                \
        return reject(message, capacity, "number of " #name " %d is not within 0 to %d",               \
                      (int)h->counts.name, largest);
    BLOB_COUNTS(CHECK_COUNT)
#undef CHECK_COUNT
    if (h->size != size || expected_size(&h->counts) != size)
        return reject(message, capacity, "the blob has %zu bytes, its header specifies %zu", size,
                      expected_size(&h->counts));
    return 0;
}

static void set_pointers(blob_view *view, const blob_header *h)
{
    const char *at = (const char *)(h + 1);
    view->counts = h->counts;
#define SET_POINTER(type, name, per_item, count)                                                       \
    view->name = (const type *)(const void *)at;                                                       \
    at += padded(sizeof(type) * per_item * (size_t)h->counts.count);
    BLOB_FIELDS(SET_POINTER)
#undef SET_POINTER
}

int blob_open(blob_view *view, const void *blob, size_t size, char *message, size_t capacity)
{
    if (!blob || size < sizeof(blob_header)) return reject(message, capacity, "the blob is too short");
    if ((uintptr_t)blob % 8) return reject(message, capacity, "the blob is not 8-byte aligned");
    if (check_header(blob, size, message, capacity)) return 1;
    set_pointers(view, blob);
    return check_robot(view, message, capacity) || check_paths(view, message, capacity) ||
           check_cable_friction(view, message, capacity) || check_parts(view, message, capacity);
}
