/* A control law ticking with a period, and what a sampled loop needs around it:

     integral action       correction += T Ki e, at rest while the law cannot be met
     disturbance observer  observer.c
     delay                 prediction.c: the law is evaluated at the state predicted for when its forces take effect

   No allocation, no global state; the robot is known by a table of functions only.                     */
#ifndef CARDSFLOW_CONTROL_LOOP_H
#define CARDSFLOW_CONTROL_LOOP_H

#include "../laws/computed_torque.h"

/* What the loop asks of a robot, at any state. */
typedef struct {
    void *self;
    /* M, n x n; h = C + G + D qd, n; L, m x n */
    void (*terms)(void *self, const real *q, const real *qd, real *M, real *h, real *L);
    /* In operational space: what is still to go to a position of the tasks, angles the shorter way round, k;
       J, k x n; J' qd, k */
    void (*tasks)(void *self, const real *q, const real *qd, const real *position, real *error,
                  real *J, real *bias);
    /* Of a robot with loops, whose terms are those of independent coordinates, NULL for others: qdd of the
       dependent ones, n; and whether each is dependent, n. */
    void (*complete)(void *self, const real *q, const real *qd, real *qdd);
    const real *dependent;
    /* For laws that need it, asked after terms: G, n; NULL for others. */
    void (*gravity)(void *self, const real *q, real *G);
} control_robot;

/* A custom law. reference: position, velocity, acceleration, 3 x r; correction: of the integral action, r;
   load: generalised, on the left of the motion equation, n.                                            */
typedef struct {
    void *self;
    /* NULL, or the torque that the forces are to make, load and correction included: tau, n. 0, or 1 for an
       error, which ends the tick with COMPUTED_TORQUE_FAILED. Only in joint space. */
    int (*torque)(void *self, const real *q, const real *qd, const real *reference, const real *correction,
                  const real *load, real *tau);
    /* NULL, or the whole law: forces, m, and slack, r; an enum computed_torque_status */
    int (*solve)(void *self, const real *q, const real *qd, const real *reference, const real *correction,
                 const real *load, real *forces, real *slack);
    /* NULL, or what is still to go to a position of the reference, r, for the integral action. */
    void (*error)(void *self, const real *q, const real *position, real *error);
} control_law;

typedef struct control_loop control_loop;

/* Bytes of working memory; sizes as for computed_torque_size. */
DUAL_NEWTON_API size_t control_loop_size(int coordinates, int muscles, int tasks);
DUAL_NEWTON_API control_loop *control_loop_open(const control_robot *robot, int coordinates, int muscles,
                                                int tasks, void *memory);
/* Put a custom law in the place of what it has. */
DUAL_NEWTON_API void control_loop_set_law(control_loop *s, const control_law *law);

/* The law in it, for its gains, bounds and weights. */
DUAL_NEWTON_API computed_torque *control_loop_law(control_loop *s);

/* An array of the loop or of its law by name; NULL if neither has it. Those of the loop are
     ki               r
     gain             1, of the observer; 0 for none
     delay, predict   1 each: ticks until forces take effect, 0 or 1; whether to compensate for that
   Results:
     acting           m: the forces from this tick to the next
     disturbance      n: the observer's load
   Everything that it remembers:
     remembered                                                                                         */
DUAL_NEWTON_API real *control_loop_array(control_loop *s, const char *name, size_t *length);

/* Forget everything; f_min acts until the first forces do. */
DUAL_NEWTON_API void control_loop_reset(control_loop *s);

/* A tick; an enum computed_torque_status of the law. reference: position, velocity, acceleration, 3 x r;
   load: known generalised load on the left of the motion equation, n.                                 */
DUAL_NEWTON_API int control_loop_tick(control_loop *s, real period, const real *q, const real *qd,
                                      const real *reference, const real *load);

#endif
