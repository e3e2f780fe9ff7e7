/* Where cables with friction bend. */
#ifndef CARDSFLOW_BENDS_H
#define CARDSFLOW_BENDS_H

#include "../blob/state.h"

/* Bends of muscle m: its via points but the ends, its wraps and its pulley; none without friction. `wrap` and
   `pulley` are where its own begin in their lists, and are moved past them; `first` is its first via point. */
static inline int32_t bends_of(const blob_view *blob, int32_t m, int32_t first, int32_t *wrap, int32_t *pulley)
{
    const int32_t end = first + blob->muscle_points[m];
    int32_t count = blob->muscle_points[m] - 2;
    for (; *wrap < blob->counts.wraps && blob->wrap_point[*wrap] < end; ++*wrap) count++;
    for (; *pulley < blob->counts.pulleys && blob->pulley_point[*pulley] < end; ++*pulley) count++;
    return value_of(blob->guide_friction[m]) > 0 ? count : 0;
}

/* bend_grip and bend_flow at the last q, whose contacts are traced. */
CORE_INSIDE void bends_move(core *c);

#endif
