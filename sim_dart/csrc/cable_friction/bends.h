/* Bends of cables with friction: at all via points except the two ends, at the pulley of the first via
   point, and at wraps. */
#ifndef CARDSFLOW_BENDS_H
#define CARDSFLOW_BENDS_H

#include "../blob/state.h"

/* A muscle whose cable has bends with friction, and the range of these bends. */
typedef struct {
    int32_t muscle, begin, end;
} bent_cable;

static inline int find_cable(const core *c, bent_cable *at)
{
    for (; at->muscle < c->blob.counts.muscles; at->muscle++) {
        at->end = at->begin + c->blob.muscle_bends[at->muscle];
        if (at->end > at->begin) return 1;
    }
    return 0;
}

#define EACH_CABLE(c, at) (bent_cable at = {0, 0, 0}; find_cable(c, &at); at.muscle++, at.begin = at.end)

/* Return s of each bend. */
static inline real *slips_of(const core *c)
{
    return c->law_states + c->blob.law_states - c->blob.counts.bends;
}

/* Return the number of wraps and pulleys of the muscle before via point `end`. `wrap` and `pulley` are
   indices of the first ones of the muscle, and are advanced past them. */
static inline int32_t contacts_before(const blob_view *blob, int32_t end, int32_t *wrap, int32_t *pulley)
{
    int32_t count = 0;
    for (; *wrap < blob->counts.wraps && blob->wrap_point[*wrap] < end; ++*wrap) count++;
    for (; *pulley < blob->counts.pulleys && blob->pulley_point[*pulley] < end; ++*pulley) count++;
    return count;
}

/* Compute bend_grip, bend_flow and bend_behind at the last q. The contacts must be traced. */
CORE_INSIDE void bends_move(core *c);

#endif
