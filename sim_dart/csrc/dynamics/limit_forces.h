/* Forces that grow smoothly outside of a range, with damping there (CoordinateLimitForce of OpenSim):
     f = -k s e - d s x',   e = distance of x from the range, s = quintic step of |e| over the transition width */
#ifndef CARDSFLOW_LIMIT_FORCES_H
#define CARDSFLOW_LIMIT_FORCES_H

#include "../blob/state.h"
#include "../math/quintic_step.h"

typedef struct {
    real beyond;             /* e */
    real stiffness, damping; /* k s and d s */
    real energy;             /* integral of k s e over e */
} limit_force;

/* Return whether a force is that of a soft limit, which limits.c computes in semi-implicit steps. */
static inline int is_soft_limit(const core *c, int32_t l)
{
    return c->has_soft_limits && c->blob.limit_variable[l] < c->blob.counts.dofs &&
           any_of(value_of(c->blob.limit_numbers[LIMIT_NUMBERS * l + 6]) > 0);
}

static inline limit_force limit_force_at(const core *c, int32_t l)
{
    const real *n = c->blob.limit_numbers + LIMIT_NUMBERS * l, x = c->at[c->blob.limit_variable[l]];
    const truth over = value_of(x) > value_of(n[1]), is_beyond = over | (value_of(x) < value_of(n[0]));
    limit_force f = {number(0), number(0), number(0), number(0)};
    if (!any_of(is_beyond)) return f;
    const real e = x - choose(over, n[1], n[0]), k = choose(over, n[3], n[2]), t = n[5], y = choose(over, e, -e) / t;
    const truth is_whole = value_of(y) >= 1;
    const real s = choose(is_whole, number(1), quintic_step(y));
    f.beyond = choose(is_beyond, e, f.beyond), f.stiffness = choose(is_beyond, k * s, f.stiffness);
    f.damping = choose(is_beyond, n[4] * s, f.damping);
    f.energy = choose(is_beyond,
                      choose(is_whole, k * (t * t * (5.0 / 14 - 0.5) + 0.5 * e * e),
                             k * t * t * y * y * y * y * y * (2 + y * (y * 6 / 7 - 2.5))),
                      f.energy);
    return f;
}

#endif
