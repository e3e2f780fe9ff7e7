/* The inside of a native controller. */
#ifndef NATIVE_CONTROLLER_STATE_H
#define NATIVE_CONTROLLER_STATE_H

#include "../../../../../controllers/csrc/computed_torque/control_loop.h"
#include "../model.h"
#include "muscles.h"

#include <stddef.h>

#define VALUES_MEMBER(name, length) double *name;
struct controller {
    struct controller_settings settings;
    CONTROLLER_GROUPS(VALUES_MEMBER) /* the values of each group */
    control_loop *loop;
    computed_torque *law;
    size_t r, k; /* rows of the reference; task coordinates that are followed, or 0 */
    size_t a;    /* actuators: muscles, and motors behind them */
    struct native_muscles muscles;
    double *falling; /* see falling.h */
    double *slid;    /* whether the last position is known, and it; n */
    const double *N, *bias; /* of robots with loops; see independent.h */
    double *room;           /* n * n + n; NULL where nothing is dependent */
    int undetermined;       /* 1 + the index of a coordinate that does not follow from the others, or 0 */
};
#undef VALUES_MEMBER

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
