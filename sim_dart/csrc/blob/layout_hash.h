/* Hash of the layout text, FNV-1a. */
#ifndef CARDSFLOW_LAYOUT_HASH_H
#define CARDSFLOW_LAYOUT_HASH_H

#include <stdint.h>

static inline uint32_t layout_hash_on(uint32_t hash, const char *text)
{
    for (; *text; text++) hash = (hash ^ (unsigned char)*text) * 16777619u;
    return hash;
}

static inline uint32_t layout_hash(const char *text)
{
    return layout_hash_on(2166136261u, text);
}

#endif
