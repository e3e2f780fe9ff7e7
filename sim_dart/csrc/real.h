/* The numbers that everything here computes with. */
#ifndef CARDSFLOW_REAL_H
#define CARDSFLOW_REAL_H

typedef double real;

#endif
