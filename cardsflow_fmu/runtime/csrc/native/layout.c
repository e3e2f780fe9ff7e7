#include "layout.h"

#include "../../../../sim_dart/csrc/blob/layout_hash.h"

#include <string.h>

#define GROUP_LINE(name, length) "group " #name "\n"
#define COUNT_LINE(name) "count " #name "\n"
#define FIELD_LINE(type, name, per_item, group) #type " " #name " " #per_item " " #group "\n"
#define LAYOUT(KIND) KIND##_GROUPS(GROUP_LINE) KIND##_COUNTS(COUNT_LINE) KIND##_FIELDS(FIELD_LINE)

const char *native_layout(enum native_kind kind)
{
    static const char *const layouts[] = {LAYOUT(PLANT), LAYOUT(CONTROLLER), LAYOUT(REFERENCE),
                                          LAYOUT(SENSORS), LAYOUT(ESTIMATOR)};
    return layouts[kind];
}

uint32_t native_layout_hash(enum native_kind kind)
{
    return layout_hash(native_layout(kind));
}

static uint64_t padded(uint64_t bytes)
{
    return (bytes + 7u) & ~(uint64_t)7u;
}

#define ADD_SIZE(type, name, per_item, group)                                                                 \
    expected += padded(sizeof(type) * per_item * (uint64_t)settings->of.group.count);
#define SET_POINTER(type, name, per_item, group)                                                              \
    settings->name = (const type *)(const void *)at;                                                          \
    at += padded(sizeof(type) * per_item * (uint64_t)settings->of.group.count);
#define READ_SETTINGS(kind, KIND)                                                                             \
    int kind##_settings_read(struct kind##_settings *settings, const void *bytes, size_t size)                \
    {                                                                                                         \
        const char *at = (const char *)bytes + sizeof settings->of;                                           \
        uint64_t expected = sizeof settings->of;                                                              \
        if (size < sizeof settings->of)                                                                       \
            return 1;                                                                                         \
        memcpy(&settings->of, bytes, sizeof settings->of);                                                    \
        KIND##_FIELDS(ADD_SIZE)                                                                               \
        if (expected != size || settings->of.models.count != 1)                                               \
            return 1;                                                                                         \
        KIND##_FIELDS(SET_POINTER)                                                                            \
        return 0;                                                                                             \
    }
READ_SETTINGS(plant, PLANT)
READ_SETTINGS(controller, CONTROLLER)
READ_SETTINGS(reference, REFERENCE)
READ_SETTINGS(sensors, SENSORS)
READ_SETTINGS(estimator, ESTIMATOR)
