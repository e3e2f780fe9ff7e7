#include "independent_terms.h"

/* Compute N and c at the last q of the core. Return nonzero if the robot has no dependent coordinates. */
static int move(struct controller *c, const struct native_robot *robot, const double *qd)
{
    if (!c->has_dependent)
        return 1;
    const int undetermined = core_free_motion(robot->core, c->settings.dependent, qd);
    if (undetermined)
        c->undetermined = undetermined;
    return 0;
}

void native_independent_open(struct controller *c, const struct native_robot *robot)
{
    for (size_t j = 0; j < robot->n; j++)
        c->has_dependent |= c->settings.dependent[j] != 0;
}

void native_independent_terms(struct controller *c, const struct native_robot *robot, const double *qd, double *M,
                              double *h, double *L)
{
    if (move(c, robot, qd))
        return;
    core_independent_bias(robot->core, (int32_t)robot->n, M, h);
    core_independent_rows(robot->core, 1, h);
    core_independent_rows(robot->core, (int32_t)c->a, L);
    core_independent_mass(robot->core, c->settings.dependent, M);
}

void native_independent_tasks(struct controller *c, const struct native_robot *robot, const double *qd, double *J,
                              double *bias)
{
    if (move(c, robot, qd))
        return;
    core_independent_bias(robot->core, (int32_t)c->k, J, bias);
    core_independent_rows(robot->core, (int32_t)c->k, J);
}

void native_independent_gravity(const struct controller *c, const struct native_robot *robot, double *G)
{
    if (c->has_dependent)
        core_independent_rows(robot->core, 1, G);
}

void native_independent_load(struct controller *c, const struct native_robot *robot, const double *q,
                             const double *qd, double *load)
{
    if (!c->has_dependent)
        return;
    core_move(robot->core, q);
    if (!move(c, robot, qd))
        core_independent_rows(robot->core, 1, load);
}

void native_independent_complete(struct controller *c, const struct native_robot *robot, const double *q,
                                 const double *qd, double *qdd)
{
    if (!c->has_dependent)
        return;
    core_move(robot->core, q);
    move(c, robot, qd);
    core_complete(robot->core, qdd);
}
