/* Time of a reference that runs slower than real time, or stops. */
#include "references.h"

#include "../../../sim_dart/csrc/math/quintic_step.h"

/* Return the integral of the relative speed from the begin of its change: that of quintic_step is 5/2 u^4 -
   3 u^5 + u^6. */
static real distance(const path_time *p, real since, real ramp)
{
    const real u = ramp > 0 && since < ramp ? since / ramp : 1;
    const real part = u * u * u * u * ((real)2.5 + u * (u - 3)), rest = since - u * (ramp > 0 ? ramp : 0);
    return p->from * since + (p->to - p->from) * ((ramp > 0 ? ramp : 0) * part + rest);
}

void path_time_reset(path_time *p)
{
    *p = (path_time){0, 1, 0, 1, 1, 0};
}

void path_time_advance(path_time *p, real h, real speed, real ramp)
{
    if (speed != p->to) p->from = p->speed, p->to = speed, p->since = 0;
    const real begin = p->since, end = begin + h, u = ramp > 0 ? end / ramp : 1;
    p->lag += h - (distance(p, end, ramp) - distance(p, begin, ramp));
    p->since = end;
    p->speed = p->from + (p->to - p->from) * (u < 1 ? quintic_step(u) : 1);
    p->acceleration = u < 1 ? (p->to - p->from) * quintic_step_rate(u) / ramp : 0;
    if (u >= 1 || p->from == p->to) p->from = p->to, p->since = 0;
}

void path_time_scale(const path_time *p, size_t r, real *rows)
{
    for (size_t i = 0; i < r; i++) {
        const real rate = rows[r + i];
        rows[r + i] = rate * p->speed;
        rows[2 * r + i] = rows[2 * r + i] * p->speed * p->speed + rate * p->acceleration;
    }
}
