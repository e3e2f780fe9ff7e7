/* Muscles with muscle laws under a control law that asks for forces: what they can come to, and the
 * commands with which they do.
 *
 * At every tick the muscles' states and the joints' velocities say which tensions can be reached within a horizon;
 * the control law chooses among them, and the commands that lead there, if they are held as long, are found by
 * inverting the muscles' laws. A horizon of one period aims at the next tick. Muscles that answer late, as a motor
 * behind a spring does, need a longer one: a command that compensates for the whole delay within a single period
 * overshoots. A drive that holds a position is commanded one that moves along with the path from tick to tick. */
#ifndef NATIVE_MUSCLES_H
#define NATIVE_MUSCLES_H

#include "../layout.h"
#include "../robot.h"

#include <stddef.h>

/* Muscle laws outside of C; to the core such a muscle is an ideal cable. NULL functions if there are none. */
struct muscle_functions {
    void *self;
    /* The commands of the core, m: of these muscles their tensions, at the core's lengths and rates. */
    void (*forces)(void *self, const double *commands, double *inner);
    /* What they can reach, into the core's force_low and force_high. */
    void (*reach)(void *self);
    /* Their commands for forces, m, into the core's commands. */
    void (*invert)(void *self, const double *forces);
};

struct native_muscles {
    const struct controller_settings *settings;
    int are_modelled;
    double *memory;         /* commands, began, has_ticked: one after the other */
    double *commands;       /* m */
    double *began;          /* m: the tensions when the commands were set */
    double *has_ticked;     /* 1 */
    double *applied;        /* m: the mean tensions since the last tick */
    double *passive_push;   /* m: what passive springs push with, never positive */
    double *least, *most;   /* m: the tensions within reach and within the bounds */
    double *inner;          /* m: the commands as the core takes them */
    struct muscle_functions outside;
    size_t m;
};

/* 0, or nonzero where memory lacks; to be closed in any case. The settings must outlive them. */
int native_muscles_open(struct native_muscles *muscles, const struct native_robot *robot,
                        const struct controller_settings *settings);
void native_muscles_close(struct native_muscles *muscles);

/* Numbers that they remember, at `memory`. */
size_t native_muscles_memory(const struct native_muscles *muscles);

void native_muscles_reset(struct native_muscles *muscles);

/* Takes over a state, its inputs in their order. Afterwards `applied` counts if they have ticked; and
 * `least`, `most`, `passive_push`, for forces within f_min and f_max. */
void native_muscles_set_state(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                        const double *qd, const double *states, const double *f_min, const double *f_max,
                        double period);

/* Finds the commands with which the tensions become these; the core may have been elsewhere since. */
void native_muscles_update(struct native_muscles *muscles, const struct native_robot *robot, const double *q,
                         const double *qd, const double *forces, double period);

#endif
