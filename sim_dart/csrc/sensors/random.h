/* Counter-based random numbers: equal for the same seed, row and column, on every platform. */
#ifndef CARDSFLOW_RANDOM_H
#define CARDSFLOW_RANDOM_H

#include "../numbers/real_functions.h"

#include <stdint.h>

/* Return a number with a normal distribution of mean 0 and variance 1: splitmix64 (Steele, Lea, Flood 2014),
   and the Box-Muller transform. */
real normal_number(uint64_t seed, uint64_t row, uint64_t column);

#endif
