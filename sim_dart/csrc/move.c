/* Going to a state, and pulling there. */
#include "state.h"

#include <math.h>
#include <string.h>

void core_move(core *c, const real *q)
{
    tree_move(c, q);
    paths_move(c);
    tasks_move(c);
}

static int is_sound(real x)
{
    return value_of(fabs(x)) <= CORE_LARGEST_STATE; /* false for NaN */
}

int core_move_checked(core *c, const real *q, const real *qd)
{
    for (int32_t i = 0; i < c->blob.counts.dofs; i++)
        if (!is_sound(q[i]) || !is_sound(qd[i])) return 1 + i;
    core_move(c, q);
    return 0;
}

int core_pull(core *c, const real *f)
{
    const int32_t dofs = c->blob.counts.dofs, muscles = c->blob.counts.muscles;
    for (int32_t k = 0; k < muscles; k++)
        if (!isfinite(f[k])) return 1 + k;
    memset(c->torques, 0, (size_t)dofs * sizeof(real));
    for (int32_t k = 0; k < muscles; k++) {
        if (value_of(f[k]) <= 0) continue;
        const real *row = c->jacobian + (size_t)k * (size_t)dofs;
        for (int32_t j = 0; j < dofs; j++) c->torques[j] -= row[j] * f[k];
    }
    return 0;
}
