/* The functions of <math.h>, for reals. Apart from real.h, which callers of core and laws include: the numbers
   that they compute with themselves may be doubles.                                                    */
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
