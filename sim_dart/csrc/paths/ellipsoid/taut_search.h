/* Search for the shortest cable over an ellipsoid. It is compiled once, for plain numbers: derivatives need only
   its result. */
#ifndef CARDSFLOW_TAUT_SEARCH_H
#define CARDSFLOW_TAUT_SEARCH_H

#include "../../numbers/real.h"

#include <stdint.h>

#if defined(CARDSFLOW_FLOAT)
typedef float plain_real;
#else
typedef double plain_real;
#endif

#define WAY_NUMBERS 5

/* All sizes are divided by the longest half axis. A way consists of the cosine and sine of the tangents from
   both ends (see fan.h), and of the length on the ellipsoid. */
typedef struct {
    plain_real r[3], ends[2][3], scaled[2][3]; /* half axes; ends, and the ends divided by the half axes */
    int32_t side;                              /* see wrap_way */
    int32_t is_continued;                      /* whether the search starts at `from` */
    plain_real from[WAY_NUMBERS];
} taut_task;

enum taut_answer { TAUT_NONE, TAUT_PATH, TAUT_PLANE };

/* Find the way. Return TAUT_PLANE if shooting fails: the way is then the shortest one in a plane. */
enum taut_answer taut_search(const taut_task *task, plain_real way[WAY_NUMBERS]);

/* Compute the Jacobi fields of the geodesic of a way at its end, and their derivatives: first of the field that
   begins with 1 and the derivative 0, then of the one that begins with 0 and the derivative 1. */
void taut_fields(const taut_task *task, const plain_real way[WAY_NUMBERS], plain_real fields[4]);

#endif
