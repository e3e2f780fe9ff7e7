/* Internal state of a native controller. */
#ifndef NATIVE_CONTROLLER_STATE_H
#define NATIVE_CONTROLLER_STATE_H

#include "policy/policy.h"
#include "../../../../../controllers/csrc/loop/control_loop.h"
#include "../model.h"
#include "muscles.h"

#include <stddef.h>

/* Arrays of the loop and of its law that every tick needs; they are looked up once. */
#define FOUND_ARRAYS(ARRAY)                                                                                   \
    ARRAY(acting) ARRAY(coming) ARRAY(seen_forces) ARRAY(gain)                                                \
    ARRAY(kp) ARRAY(kd) ARRAY(f_min) ARRAY(f_max) ARRAY(forces) ARRAY(slack) ARRAY(limits_dropped) ARRAY(f_p)

struct motion_feedback; /* see motion_feedback.c */

#define VALUES_MEMBER(name, length) double *name;
#define ARRAY_MEMBER(name) double *name;
struct predictive; /* see predictive.h */
struct reacting;   /* see reacting.c */
struct controller {
    struct controller_settings settings;
    CONTROLLER_GROUPS(VALUES_MEMBER) /* the values of each group */
    control_loop *loop;
    struct {
        FOUND_ARRAYS(ARRAY_MEMBER)
    } in_loop;
    size_t r, k; /* rows of the reference; number of controlled task coordinates, or 0 */
    size_t a;    /* number of actuators: muscles, then motors */
    struct native_muscles muscles;
    struct predictive *predictive; /* model predictive control, or NULL */
    struct motion_feedback *motion; /* forces and gains of an optimal motion, or NULL */
    struct reacting *reacting; /* reaction to lost muscles, or NULL */
    double *ramp; /* see ramp.h */
    double *last_position;    /* n + 1: whether the last position is valid; the position */
    policy policy; /* without layers: none */
    double *policy_scratch;
    int has_dependent; /* whether loops make coordinates dependent on others; see independent_terms.h */
    int undetermined;       /* 1 + the index of a coordinate that does not follow from the others, or 0 */
};
#undef VALUES_MEMBER
#undef ARRAY_MEMBER

static inline double *loop_array(const struct controller *c, const char *name, size_t *length)
{
    return control_loop_array(c->loop, name, length);
}

/* Functions of motion_feedback.c: the forces and gains of an optimal motion. They have no effect without one. */

/* Read the motion of the settings, and use it in the loop. Return 0, or nonzero with a message; must be closed
 * in either case. */
int native_motion_open(struct controller *c, const struct native_robot *robot, struct text *error);
void native_motion_close(struct controller *c);

/* Set the time of a tick, whose state is predicted by one period if the loop predicts it. */
void native_motion_set(struct controller *c, double time, double period);

/* Return the status of a tick. The feedback along a motion, which the limits of forces may restrict, is feasible. */
int native_motion_status(const struct controller *c, int status);

/* Return the commands of all muscles after a tick, m; NULL if the forces determine them. */
const double *native_motion_commands(const struct controller *c);

#endif
