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

static inline limit_force limit_force_at(const core *c, int32_t l)
{
    const real *n = c->blob.limit_numbers + LIMIT_NUMBERS * l, x = c->at[c->blob.limit_variable[l]];
    const int over = value_of(x) > value_of(n[1]), under = value_of(x) < value_of(n[0]);
    limit_force f = {0, 0, 0, 0};
    if (!over && !under) return f;
    const real e = x - (over ? n[1] : n[0]), k = over ? n[3] : n[2], t = n[5], y = (over ? e : -e) / t;
    const int is_whole = value_of(y) >= 1;
    const real s = is_whole ? 1 : quintic_step(y);
    f.beyond = e, f.stiffness = k * s, f.damping = n[4] * s;
    f.energy = is_whole ? k * (t * t * (5.0 / 14 - 0.5) + 0.5 * e * e)
                        : k * t * t * y * y * y * y * y * (2 + y * (y * 6 / 7 - 2.5));
    return f;
}

#endif
