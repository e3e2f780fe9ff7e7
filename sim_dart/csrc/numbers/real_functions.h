/* The functions of <math.h> for reals. They are separate from real.h, which callers of core and laws
   include: the numbers of these callers may be doubles. */
#ifndef CARDSFLOW_REAL_FUNCTIONS_H
#define CARDSFLOW_REAL_FUNCTIONS_H

#include "real.h"

#if defined(CARDSFLOW_FLOAT)
#undef fabs
#undef sqrt
#define fabs(x) fabsf(x)
#define sqrt(x) sqrtf(x)
#define fmod(x, y) fmodf(x, y)
#define ceil(x) ceilf(x)
#define round(x) roundf(x)
#endif

#endif
