/* Where cables with friction bend: at the via points but the ends, at the pulley of the first one, over wraps. */
#ifndef CARDSFLOW_BENDS_H
#define CARDSFLOW_BENDS_H

#include "../blob/state.h"

/* Wraps and pulleys of the muscle before via point `end`. `wrap` and `pulley` are where its own begin in their
   lists, and are moved past them. */
static inline int32_t contacts_before(const blob_view *blob, int32_t end, int32_t *wrap, int32_t *pulley)
{
    int32_t count = 0;
    for (; *wrap < blob->counts.wraps && blob->wrap_point[*wrap] < end; ++*wrap) count++;
    for (; *pulley < blob->counts.pulleys && blob->pulley_point[*pulley] < end; ++*pulley) count++;
    return count;
}

/* bend_grip and bend_flow at the last q, whose contacts are traced. */
CORE_INSIDE void bends_move(core *c);

#endif
