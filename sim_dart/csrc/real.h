/* The numbers that everything here computes with. */
#ifndef CARDSFLOW_REAL_H
#define CARDSFLOW_REAL_H

#ifdef CARDSFLOW_ALONG
#include "along/number.h"
#else

typedef double real;

/* Whether numbers carry along how they change; see along.h. */
#define IS_ALONG 0

/* What a comparison looks at: the number, without what it carries along. */
static inline double value_of(real x)
{
    return x;
}

/* What it carries along. */
static inline double change_of(real x)
{
    (void)x;
    return 0;
}

#endif
#endif
