#include "random.h"

#include "../math/elementary.h"

static uint64_t mix_bits(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return x ^ x >> 31;
}

/* Return a number in (0, 1], in steps of 2^-24, which single precision can represent. */
static real uniform(uint64_t bits)
{
    return ((real)(bits >> 40) + 1) / 16777216;
}

real normal_number(uint64_t seed, uint64_t row, uint64_t column)
{
    const uint64_t first = mix_bits(mix_bits(mix_bits(seed) ^ row) ^ column);
    return sqrt(-2 * logarithm(uniform(first))) * cosine((real)(2 * PI) * uniform(mix_bits(first)));
}
