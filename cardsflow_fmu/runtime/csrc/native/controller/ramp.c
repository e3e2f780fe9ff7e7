#include "ramp.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

size_t native_ramp_memory(const struct controller *c)
{
    return c->settings.of.valid.count ? 1 + c->a + c->settings.of.q.count : 0;
}

int native_ramp_open(struct controller *c)
{
    c->ramp = calloc(native_ramp_memory(c) + 1, sizeof *c->ramp);
    return !c->ramp;
}

void native_ramp_reset(struct controller *c, const double *forces)
{
    if (!c->settings.of.valid.count)
        return;
    c->ramp[0] = 1;
    memcpy(c->ramp + 1, forces, c->a * sizeof(double));
    memcpy(c->ramp + 1 + c->a, c->settings.q_start, c->settings.of.q.count * sizeof(double));
}

int native_ramp_is_due(const struct controller *c)
{
    return c->settings.of.valid.count && c->valid[0] == 0;
}

/* Return the smallest force of a muscle, or zero torque of a motor, within its bounds. */
static double rest(const struct controller *c, size_t i)
{
    return fmin(fmax(0, c->f_min[i]), c->f_max[i]);
}

void native_ramp_down(struct controller *c, double period)
{
    double *share = c->ramp, *law = share + 1;
    const double down = c->settings.ramp_down[0];
    *share = down > 0 ? fmax(0, *share - period / down) : 0;
    for (size_t i = 0; i < c->a; i++)
        c->forces[i] = rest(c, i) + *share * (law[i] - rest(c, i));
    control_loop_reset(c->loop);
    memcpy(c->in_loop.acting, c->forces, c->a * sizeof(double));
    memcpy(c->in_loop.coming, c->forces, c->a * sizeof(double));
}

void native_ramp_up(struct controller *c, double period)
{
    double *share = c->ramp, *law = share + 1;
    double *acting = c->in_loop.acting;
    const double up = c->settings.ramp_in[0];
    if (!c->settings.of.valid.count)
        return;
    memcpy(law, acting, c->a * sizeof(double));
    memcpy(law + c->a, c->q, c->settings.of.q.count * sizeof(double));
    if (*share >= 1)
        return;
    *share = up > 0 ? fmin(1, *share + period / up) : 1;
    for (size_t i = 0; i < c->a; i++)
        if (*share < 1)
            acting[i] = rest(c, i) + *share * (law[i] - rest(c, i));
    memcpy(c->in_loop.seen_forces, acting, c->a * sizeof(double));
}
