/* The inside of a native controller. */
#ifndef NATIVE_CONTROLLER_H
#define NATIVE_CONTROLLER_H

#include "../../../controllers/csrc/control_loop.h"
#include "native_model.h"
#include "native_muscles.h"

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

/* Fills in what the law and the loop hold, from the settings that are left. 0, or nonzero where they do not
 * fit. */
int native_controller_settings(struct controller *c, struct native_model *native);

#endif
