/* Motion of the core to a state. */
#include "../kinematics/tasks.h"
#include "../kinematics/tree.h"
#include "../laws/laws.h"
#include "../numbers/real_functions.h"
#include "../paths/paths.h"

#include <math.h>

void core_move(core *c, const real *q)
{
    tree_move(c, q);
    paths_move(c);
    if (c->has_weight) laws_place(c);
    tasks_move(c);
}

/* Return whether one of both is too large. */
static truth is_unsound(real q, real qd)
{
    const truth is_near = value_of(fabs(q)) <= CORE_MAX_STATE, is_slow = value_of(fabs(qd)) <= CORE_MAX_STATE;
    return (is_near & is_slow) == 0; /* also for NaN */
}

int core_move_checked(core *c, const real *q, const real *qd)
{
    for (int32_t i = 0; i < c->blob.counts.dofs; i++)
        if (is_rare(c, is_unsound(q[i], qd[i]))) return 1 + i;
    core_move(c, q);
    return 0;
}
