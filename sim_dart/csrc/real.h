/* The numbers that everything here computes with. */
#ifndef CARDSFLOW_REAL_H
#define CARDSFLOW_REAL_H

typedef double real;

/* What a comparison looks at. */
static inline real value_of(real x)
{
    return x;
}

#endif
