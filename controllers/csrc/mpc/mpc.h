/* Model predictive control of muscle forces: at every tick one step of sequential quadratic programming (a
   real-time iteration) over N intervals with constant forces, from the last motion shifted in time. The first
   interval is the period of the ticks, in which its forces act; the others are of equal length.

     min   int tracking e^2 + tracking_rates e'^2 + accelerations e''^2 + posture + speeds qd^2
               + forces (f - f_p)^2 dt + sum_k force_rates (f_k - f_k-1)^2 / h + cost to go
     s.t.  x_k+1 = F(x_k, f_k),   f_min <= f <= f_max,   q_min <= q <= q_max (soft),  |qd| <= qd_max (soft)

   e is the error of the reference, in joint or task coordinates. With the cost to go of the double integrator
   e'' = a without bounds, the terms of e are, except for a constant,

     int (sqrt(accelerations) e'' + d e' + sqrt(tracking) e)^2 dt,
     d^2 = tracking_rates + 2 sqrt(tracking accelerations)

   In this form, the law without active bounds is the computed torque with Kp^2 = tracking, Kd = d and
   accelerations = 1, for any horizon and any number of intervals.

   The law does not allocate memory, has no global state and no I/O. */
#ifndef CARDSFLOW_MPC_H
#define CARDSFLOW_MPC_H

#include "../loop/control_loop.h"
#include "../../../sim_dart/csrc/stage_qp/stage_qp.h"

typedef struct mpc mpc;

/* Functions of the robot and of the reference. */
typedef struct {
    void *self;
    /* Simulate the N intervals of h seconds, N, that start with x = (q, qd), N x 2n, with constant forces, N x a,
       and a constant load on the left side of the motion equation, n. Compute the states at their ends, N x 2n,
       and their derivatives by the forces and by x, N x 2n x (a + 2n). Return nonzero if a state diverged. */
    int (*intervals)(void *self, const real *h, const real *x, const real *forces, const real *load, real *ends,
                     real *derivatives);
    /* See control_robot; only for k > 0. */
    void (*tasks)(void *self, const real *q, const real *qd, const real *position, real *error, real *J, real *bias);
    /* Compute position, velocity and acceleration of the reference, 3 x r, `ahead` seconds after the tick,
       whose reference is `now`. */
    void (*preview)(void *self, real ahead, const real *now, real *reference);
    /* Return the seconds of a monotonic clock, for the deadline; or NULL without a clock. */
    double (*clock)(void *self);
} mpc_model;

/* Return the size of the working memory in bytes; arguments as for computed_torque_size and stage_qp_size. */
DUAL_NEWTON_API size_t mpc_size(int coordinates, int actuators, int tasks, int nodes);
DUAL_NEWTON_API mpc *mpc_open(const mpc_model *model, int coordinates, int actuators, int tasks, int nodes,
                              void *memory);

/* Return an array by name, and its length; NULL if it does not exist.

     horizon          1: sum of the lengths of the intervals, in [s]; longer than the period
     period           1, of the ticks, in [s]
     iterations       1: maximum of a tick, of the interior-point method; four times as many in the first one
     tolerance        1: of its complementarity
     deadline         1: seconds from the begin of a tick, in which its iterations must end; 0: none, and the
                      law does not read the clock. Without a clock, `iterations` limits the time
     tracking, tracking_rates, accelerations     r each
     posture, posture_rates, posture_accelerations, q0   n each; only in operational space
     speeds           n
     forces_cost, force_rates, f_p   a each
     f_min, f_max     a
     first_min, first_max   a: bounds in the first interval
     plan_min, plan_max     a: narrower bounds of the user; callers combine them with the limits in the others
     q_min, q_max, qd_max   n; infinite without a bound
     limit_penalty    n: cost of a violation of the bounds of q and qd, per s
   Results:
     used             1: iterations of the interior-point method in the last tick
     is_late          1: whether the deadline ended them, or the tick was longer
   Internal state:
     planned          1 + (N + 1) 2n + N a: whether a motion exists; its states and forces */
DUAL_NEWTON_API real *mpc_array(mpc *s, const char *name, size_t *length);

/* Forget the last motion. */
DUAL_NEWTON_API void mpc_reset(mpc *s);

/* A control_law `solve`; `self` is an mpc. Return COMPUTED_TORQUE_SOLVED, or COMPUTED_TORQUE_NEXT if no
   solution was found in time, and the computed-torque law must compute the forces. The next tick starts from
   the last motion also after a late tick. */
DUAL_NEWTON_API int mpc_solve(void *self, const real *q, const real *qd, const real *reference,
                              const real *correction, const real *load, real *forces, real *slack);

#endif
