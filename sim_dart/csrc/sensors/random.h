/* Random numbers by their place: the same for the same seed, row and column, on every platform. */
#ifndef CARDSFLOW_RANDOM_H
#define CARDSFLOW_RANDOM_H

#include "../numbers/real_functions.h"

#include <stdint.h>

/* Of the normal distribution with mean 0 and variance 1: splitmix64 (Steele, Lea, Flood 2014), and Box and Muller. */
real normal_number(uint64_t seed, uint64_t row, uint64_t column);

#endif
