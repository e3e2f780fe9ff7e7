/* The inside of a native controller. */
#ifndef NATIVE_CONTROLLER_STATE_H
#define NATIVE_CONTROLLER_STATE_H

#include "../../../../../controllers/csrc/computed_torque/control_loop.h"
#include "../model.h"
#include "muscles.h"

#include <stddef.h>

struct controller {
    control_loop *loop;
    computed_torque *law;
    size_t r, k; /* rows of the reference; task coordinates that are followed, or 0 */
    struct native_muscles muscles;
    double *q, *qd, *reference, *loads, *states;
    double *forces, *commands, *slack, *report, *kp, *kd, *f_min, *f_max, *period;
    const double *is_angle;
    double observer;
};

static inline double *law_array(const struct controller *c, const char *name)
{
    size_t length;
    return computed_torque_array(c->law, name, &length);
}

static inline double *loop_array(const struct controller *c, const char *name, size_t *length)
{
    return control_loop_array(c->loop, name, length);
}

#endif
