/* The functions of the C library that the core and the control laws call, for machines without one.

   Weak, so that those of a toolchain, which are faster, come first. Compile with -fno-builtin: a compiler
   may take the loops for what they are and call the function that it is in.                            */
#include "math.h"
#include "string.h"

#include <stdint.h>

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

/* x less a whole multiple of y, exactly: y times a power of two, halved again and again, is taken off
   wherever it fits, and such differences are not rounded.                                              */
WEAK double fmod(double x, double y)
{
    double rest = fabs(x), step = fabs(y);
    const double end = step;
    if (!isfinite(x) || !(end > 0)) return NAN;
    if (isinf(end)) return x;
    while (step <= rest / 2) step *= 2;
    for (; step >= end; step /= 2)
        if (rest >= step) rest -= step;
    return signbit(x) ? -rest : rest;
}

static const double WHOLE = 4503599627370496.0; /* 2^52: from here on whole */

static double towards_zero(double x)
{
    if (!(fabs(x) < WHOLE)) return x; /* also NaN */
    const double whole = (double)(int64_t)fabs(x);
    return signbit(x) ? -whole : whole;
}

WEAK double ceil(double x)
{
    const double whole = towards_zero(x);
    return whole < x ? whole + 1 : whole;
}

/* Halves away from zero. */
WEAK double round(double x)
{
    const double whole = towards_zero(x);
    return fabs(x - whole) < 0.5 ? whole : whole + (x < 0 ? -1 : 1);
}
