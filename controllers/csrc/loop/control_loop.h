/* A periodic control law, with the additional functions of a sampled loop:

     integral action       correction += T Ki e, constant while the law is infeasible
     disturbance observer  observer.c
     delay                 prediction.c: evaluates the law at the state when its forces will take effect

   The loop does not allocate memory and has no global state. It accesses the robot only by a table of
   functions. */
#ifndef CARDSFLOW_CONTROL_LOOP_H
#define CARDSFLOW_CONTROL_LOOP_H

#include "../laws/computed_torque.h"

/* Functions of the robot that the loop calls, at any state. */
typedef struct {
    void *self;
    /* Compute M, n x n; h = C + G + D qd, n; L, m x n. */
    void (*terms)(void *self, const real *q, const real *qd, real *M, real *h, real *L);
    /* In operational space, compute the difference of a task position from the current one, with angles on
       the shorter way, k; J, k x n; J' qd, k. */
    void (*tasks)(void *self, const real *q, const real *qd, const real *position, real *error,
                  real *J, real *bias);
    /* For a robot with loops, whose terms are those of independent coordinates, otherwise NULL: compute qdd
       of the dependent coordinates, n. `dependent` is a flag for each coordinate, n. */
    void (*complete)(void *self, const real *q, const real *qd, real *qdd);
    const real *dependent;
    /* Compute G, n, for laws that need it; called after `terms`. Otherwise NULL. */
    void (*gravity)(void *self, const real *q, real *G);
} control_robot;

/* A custom law. reference: position, velocity, acceleration, 3 x r; correction: of the integral action, r;
   load: generalised, on the left side of the motion equation, n. */
typedef struct {
    void *self;
    /* Compute the torque tau that the forces produce, including load and correction, n; or NULL. Return 0,
       or 1 for an error, which ends the tick with COMPUTED_TORQUE_FAILED. Only in joint space. */
    int (*torque)(void *self, const real *q, const real *qd, const real *reference, const real *correction,
                  const real *load, real *tau);
    /* Compute the forces, m, and slack, r; or NULL. Return an enum computed_torque_status;
       after COMPUTED_TORQUE_NEXT the law in C computes the forces. */
    int (*solve)(void *self, const real *q, const real *qd, const real *reference, const real *correction,
                 const real *load, real *forces, real *slack);
    /* Compute the position error of the reference, r, for the integral action; or NULL. */
    void (*error)(void *self, const real *q, const real *position, real *error);
} control_law;

typedef struct control_loop control_loop;

/* Return the size of the working memory in bytes; arguments as for computed_torque_size. */
DUAL_NEWTON_API size_t control_loop_size(int coordinates, int muscles, int tasks);
DUAL_NEWTON_API control_loop *control_loop_open(const control_robot *robot, int coordinates, int muscles,
                                                int tasks, void *memory);
/* Replace the law by a custom law. */
DUAL_NEWTON_API void control_loop_set_law(control_loop *s, const control_law *law);

/* Return an array of the loop or of its law by name; NULL if it does not exist. The arrays of the loop are

     ki               r
     gain             1, of the observer; 0 to disable it
     midpoint         1: whether the observer compares with the model in the middle of the last tick, for laws that
                      predict the motion between ticks. Others assume the terms of its begin, also the observer
     delay, predict   1 each: ticks until forces take effect, 0 or 1; whether to compensate for the delay
   Results:
     acting           m: forces from this tick to the next
     disturbance      n: load estimated by the observer
   Internal state, to be saved and restored:
     remembered */
DUAL_NEWTON_API real *control_loop_array(control_loop *s, const char *name, size_t *length);

/* Reset; f_min acts until the first forces take effect. */
DUAL_NEWTON_API void control_loop_reset(control_loop *s);

/* Compute a tick. Return an enum computed_torque_status of the law. reference: position, velocity,
   acceleration, 3 x r; load: known generalised load on the left side of the motion equation, n. */
DUAL_NEWTON_API int control_loop_tick(control_loop *s, real period, const real *q, const real *qd,
                                      const real *reference, const real *load);

#endif
