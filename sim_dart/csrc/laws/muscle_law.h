/* Iteration over the muscles of a robot with their laws. */
#ifndef CARDSFLOW_MUSCLE_LAW_H
#define CARDSFLOW_MUSCLE_LAW_H

#include "../blob/state.h"
#include "../optional_parts.h"
#include "law.h"

#if IS_ONE_UNIT
#include "../../generated/law_table.h"
#else
extern const law_entry LAW_TABLE[];
#endif

/* Iterator over the muscles, with the offsets of their data. */
typedef struct {
    const law_entry *entry;
    const tension_law *law;
    const real *p;
    real *k, *x, *xd, scale;
    int32_t m, states;
} muscle_law;

static inline int muscle_law_at(const core *c, muscle_law *at)
{
    if (at->m >= c->blob.counts.muscles) return 0;
    at->entry = LAW_TABLE + c->blob.law_kind[at->m], at->law = at->entry->law;
    at->states = index_of(at->k[LAW_STATES]), at->scale = c->tension_scale[at->m];
    return 1;
}

static inline int first_muscle(const core *c, muscle_law *at)
{
    at->entry = NULL, at->law = NULL, at->scale = number(0);
    at->m = at->states = 0, at->p = c->blob.law_parameter;
    at->k = c->law_constants, at->x = c->law_states, at->xd = c->law_rates;
    return muscle_law_at(c, at);
}

static inline int next_muscle(const core *c, muscle_law *at)
{
    at->m++, at->p += at->entry->parameters, at->k += at->law->constants;
    at->x += at->states, at->xd += at->states;
    return muscle_law_at(c, at);
}

#define EACH_MUSCLE(c, at) (int more = first_muscle(c, at); more; more = next_muscle(c, at))

static inline real command(const muscle_law *at, const real *u)
{
    return at->entry->driven ? clamped(u[at->m], at->k[LAW_LOW], at->k[LAW_HIGH]) : number(0);
}

/* Return whether the second state is the length of a fibre with an elastic tendon. */
static inline int has_fibre(const muscle_law *at)
{
    return at->law->settle && at->states == 2;
}

/* Return whether the muscle is a cable with friction that stretches along its path. */
static inline int does_stretch(const core *c, int32_t m)
{
    return USES_CABLE_FRICTION && c->blob.stretches && LAW_TABLE[c->blob.law_kind[m]].law->stretch && c->blob.muscle_bends[m];
}

/* Return the length of a path at the driven end, for its law. */
static inline real length_at(const core *c, int32_t m)
{
    return does_stretch(c, m) ? c->lengths[m] - c->cable_beyond[m] : c->lengths[m];
}

static inline int has_bends(const core *c)
{
    return USES_CABLE_FRICTION && c->blob.counts.bends;
}

static inline real bounded_tension(const muscle_law *at, const real *x, real l, real v, real u)
{
    const real f = at->scale * at->law->tension(at->k, x, l, v, u);
    return clamped(f, number(at->entry->pushes ? -MAX_TENSION : 0), number(MAX_TENSION));
}

#endif
