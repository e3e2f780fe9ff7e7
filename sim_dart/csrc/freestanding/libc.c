/* Functions of the C library that the core and the control laws call, for machines without one.

   They are weak symbols, so that the faster functions of a toolchain take precedence. Compile with
   -fno-builtin: otherwise a compiler may replace a loop by a call of the function that contains it. */
#include "../numbers/real_functions.h"
#include "string.h"

#define WEAK __attribute__((weak))

WEAK void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    unsigned char *out = to;
    const unsigned char *in = from;
    while (size--) *out++ = *in++;
    return to;
}

WEAK void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *out = to;
    const unsigned char *in = from;
    if (out < in)
        while (size--) *out++ = *in++;
    else
        while (size--) out[size] = in[size];
    return to;
}

WEAK void *memset(void *to, int byte, size_t size)
{
    unsigned char *out = to;
    while (size--) *out++ = (unsigned char)byte;
    return to;
}

WEAK int strncmp(const char *a, const char *b, size_t size)
{
    for (; size && *a && *a == *b; size--) a++, b++;
    return size ? (unsigned char)*a - (unsigned char)*b : 0;
}

WEAK int strcmp(const char *a, const char *b)
{
    return strncmp(a, b, SIZE_MAX);
}

/* Return the remainder of x / y, exactly: y times a power of two, halved repeatedly, is subtracted while it
   fits; these differences are not rounded. */
WEAK real fmod(real x, real y)
{
    real rest = fabs(x), step = fabs(y);
    const real end = step;
    if (!isfinite(x) || !(end > 0)) return NAN;
    if (isinf(end)) return x;
    while (step <= rest / 2) step *= 2;
    for (; step >= end; step /= 2)
        if (rest >= step) rest -= step;
    return signbit(x) ? -rest : rest;
}

static const real WHOLE = PRECISE(4503599627370496.0, 8388608.0); /* 2^52, 2^23: larger numbers are integers */

static real towards_zero(real x)
{
    if (!(fabs(x) < WHOLE)) return x; /* also for NaN */
    const real cut = (real)(whole_number)fabs(x);
    return signbit(x) ? -cut : cut;
}

WEAK real ceil(real x)
{
    const real cut = towards_zero(x);
    return cut < x ? cut + 1 : cut;
}

/* Round to the nearest integer, halves away from zero. */
WEAK real round(real x)
{
    const real cut = towards_zero(x);
    return fabs(x - cut) < 0.5 ? cut : cut + (x < 0 ? -1 : 1);
}
