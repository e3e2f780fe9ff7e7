/* The hash of a layout's text, FNV-1a. */
#ifndef CARDSFLOW_LAYOUT_HASH_H
#define CARDSFLOW_LAYOUT_HASH_H

#include <stdint.h>

static inline uint32_t layout_hash(const char *text)
{
    uint32_t hash = 2166136261u;
    for (; *text; text++) hash = (hash ^ (unsigned char)*text) * 16777619u;
    return hash;
}

#endif
