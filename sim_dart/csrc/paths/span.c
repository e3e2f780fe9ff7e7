#include "span.h"

void span_add(const core *c, const real u[3], const real A[3], int32_t a, const real B[3], int32_t b, real *row)
{
    add_span(c, u, A, a, B, b, row);
}
