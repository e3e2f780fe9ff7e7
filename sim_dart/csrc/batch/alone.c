#include "lane_support.h"

#if HAS_LANES
#include "alone.h"

#include "../dynamics/limits.h"
#include "../integrators/semi_implicit_euler.h"

void alone_enforce_limits(core *c)
{
    limits_enforce(c, c->qd);
}

int alone_finish(core *c, const double *u, const double *extra, double h, int32_t steps)
{
    core_move(c, c->q);
    return euler_steps(c, u, extra, h, steps);
}

#endif
