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

static int is_sound(real x)
{
    return value_of(fabs(x)) <= CORE_MAX_STATE; /* false for NaN */
}

int core_move_checked(core *c, const real *q, const real *qd)
{
    for (int32_t i = 0; i < c->blob.counts.dofs; i++)
        if (!is_sound(q[i]) || !is_sound(qd[i])) return 1 + i;
    core_move(c, q);
    return 0;
}
