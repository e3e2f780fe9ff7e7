/* Muscles with muscle laws under a control law that requests forces: the reachable tensions, and the
 * commands that reach them.
 *
 * At every tick the reachable tensions within a horizon are computed from the states of the muscles and the
 * velocities of the joints. The control law selects among them. The commands that reach these tensions, if
 * they are held during the horizon, result from inverting the muscle laws. A horizon of one period aims at
 * the next tick. Muscles with a delay, such as a motor with a spring, need a longer horizon: a command that
 * compensates for the whole delay within a single period overshoots. A position command of a drive moves
 * along with the path from tick to tick. */
#ifndef NATIVE_MUSCLES_H
#define NATIVE_MUSCLES_H

#include "../layout.h"
#include "../robot.h"

#include <stddef.h>

/* Muscle laws outside of C; the core treats such a muscle as an ideal cable. The functions are NULL if no
 * such muscles exist. */
struct muscle_functions {
    void *self;
    /* Compute the commands of the core, m: for these muscles the tensions, at the lengths and rates of the
     * core. */
    void (*forces)(void *self, const double *commands, double *inner);
    /* Compute force_low and force_high of the core for these muscles. */
    void (*reach)(void *self);
    /* Compute the commands of these muscles for forces, m, in `commands` of the core. */
    void (*invert)(void *self, const double *forces);
};

struct native_muscles {
    const struct controller_settings *settings;
    int are_modelled;
    double *memory;         /* commands, began, has_ticked: contiguous */
    double *commands;       /* m */
    double *began;          /* m: the tensions when the commands were set */
    double *has_ticked;     /* 1 */
    double *applied;        /* m: the mean tensions since the last tick */
    double *passive_push;   /* m: push of passive springs, never positive */
    double *least, *most;   /* m: the reachable tensions within the bounds */
    double *inner;          /* m: the commands of the core */
    struct muscle_functions outside;
    size_t m;
};

/* Return 0, or nonzero if memory is insufficient; must be closed in either case. The settings must outlive
 * the muscles. */
int native_muscles_open(struct native_muscles *muscles, const struct native_robot *robot,
                        const struct controller_settings *settings);
void native_muscles_close(struct native_muscles *muscles);

/* Return the number of values of the internal state, at `memory`. */
size_t native_muscles_memory(const struct native_muscles *muscles);

void native_muscles_reset(struct native_muscles *muscles);

/* Set a state; the inputs are in their order. Afterwards `applied` is valid after the first tick; `least`,
 * `most` and `passive_push` are valid, for forces within f_min and f_max. */
void native_muscles_set_state(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                              const double *qd, const double *states, const double *f_min, const double *f_max,
                              double period);

/* Compute the tensions for the current commands, in `forces` of muscles with laws; those of ideal cables do
 * not change. */
void native_muscles_hold(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                         const double *qd, const double *states, double *forces);

/* Compute the commands for these tensions; the core may have moved since. */
void native_muscles_update(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                           const double *qd, const double *forces, double period);

/* Set the commands, m, themselves; `began` contains the tensions afterwards. */
void native_muscles_command(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                            const double *qd, const double *commands);

#endif
