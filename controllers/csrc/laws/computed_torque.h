/* Control laws by muscle forces: computed torque in joint space, eq. (3) of the CARDSFlow paper, the laws of
   joint/, and computed torque in operational space, eq. (4). The caller provides the terms of the robot at
   the current state, M, C + G, L, J and J' qd; the laws do not depend on a robot model.

   A law is a quadratic program. computed_torque_solve builds, solves and finishes it. Callers with a
   different solver call the three steps separately:

     status = computed_torque_build(s);
     do {
         ... x from the arrays of computed_torque_program(s) ...
         status = computed_torque_finish(s, x);
     } while (status == COMPUTED_TORQUE_NEXT);
     if (status == COMPUTED_TORQUE_FAILED) status = computed_torque_solve(s);    (x was not a solution)

   The laws do not allocate memory, have no global state and no I/O: the caller owns the working memory.
   Every function of one handle must be called from one thread at a time. */
#ifndef CARDSFLOW_COMPUTED_TORQUE_H
#define CARDSFLOW_COMPUTED_TORQUE_H

#include "../qp/dual_newton.h"

typedef struct computed_torque computed_torque;

enum computed_torque_status {
    COMPUTED_TORQUE_SOLVED = 0,
    COMPUTED_TORQUE_SOFT = 1,          /* proven infeasible; the forces have the smallest error */
    COMPUTED_TORQUE_NOT_CONVERGED = 2, /* not converged, feasibility unknown; smallest error */
    COMPUTED_TORQUE_FAILED = 3,        /* also the smallest error was not found; the forces do not change */
    COMPUTED_TORQUE_WRONG = 4,         /* an input is not finite or out of range */
    COMPUTED_TORQUE_NEXT = 5           /* of computed_torque_finish: continue with the next priority */
};

/* Value of the array `law`: the torque is given in the array `tau`. */
#define COMPUTED_TORQUE_GIVEN (-1)

/* Return the value of the array `law` for a joint-space law by name, as in joint/; -1 if the law does not
   exist. */
DUAL_NEWTON_API int computed_torque_law(const char *name);

/* Return whether the law selected in the array `law` needs G. */
DUAL_NEWTON_API int computed_torque_needs_gravity(const computed_torque *s);

/* Return the size of the working memory in bytes for a robot of n coordinates and m muscles, with k task
   coordinates; k = 0 in joint space. Motors at joints are included as muscles that may push, with further
   rows of L and negative f_min. Return 0 if a number is too small or too large. */
DUAL_NEWTON_API size_t computed_torque_size(int coordinates, int muscles, int tasks);

/* Create a handle in `memory`, which is 8-byte aligned and has computed_torque_size bytes; this call sets it
   to zero. Return NULL if the memory or a size is rejected. */
DUAL_NEWTON_API computed_torque *computed_torque_open(int coordinates, int muscles, int tasks,
                                                      void *memory);

/* Return an array by name, and its number of elements; NULL if the array does not exist. r is the number of
   rows of the reference: n in joint space, k in operational space.

   To be written at every call:
     M, h, L               mass matrix n x n; C + G + D qd, n; muscle Jacobian, m x n
     G                     gravity, n; for laws that need it: see computed_torque_needs_gravity
     load                  known generalised load on the left side of the motion equation, n
     error, rate_error     position and velocity of the reference minus those of the robot, r
     acceleration          of the reference, r
     correction            added to the commanded acceleration, or torque, r
     q, qd                 n; qd in joint space for torque_position
     J, bias               task Jacobian k x n; J' qd, k; in operational space
     tau                   n; input for the law COMPUTED_TORQUE_GIVEN, otherwise the torque of the law
   To be written before:
     law                   1: see computed_torque_law; in joint space
     kp, kd                r
     f_min, f_max          m
     H_f                   cost of the forces, m
     f_p                   pretension, m
     norm                  1; in joint space: norm of H_f^1/2 (f - f_p), 1 to 8 or infinite; 0 for 2
     passive               n; 1 for coordinates that are not controlled, in joint space
     tolerance             1; in joint space: maximum torque shortfall, relative to 1 + max |tau|; 0 for 1e-6
    and in operational space
     H_q, H_r              cost of accelerations, n, and of changes of forces, m
     W                     weights of the tasks, k; infinite for an exact task
     priority              rank of each task, k: tasks of lower rank come first, at any cost for those of higher rank
     posture_kp, posture_kd, q0           n
     q_min, q_max          n; infinite without a limit
     limit_bandwidth       1; 0 to ignore the limits
   Results:
     forces                m
     slack                 shortfall, r: of the torque in joint space, of the acceleration in operational space
     qdd                   accelerations due to the forces, n; in operational space
     limits_dropped        1: whether joint limits had to be dropped
   Internal state, to be saved and restored for bit-identical results:
     memory */
DUAL_NEWTON_API real *computed_torque_array(computed_torque *s, const char *name, size_t *length);

/* Reset the warm starts and the last forces, which become the smallest ones within their bounds. */
DUAL_NEWTON_API void computed_torque_reset(computed_torque *s);

/* Compute the forces. Return an enum computed_torque_status. */
DUAL_NEWTON_API int computed_torque_solve(computed_torque *s);

/* Compute tau of the law in joint space. */
DUAL_NEWTON_API void computed_torque_require(computed_torque *s);

/* Build the program of the first priority. Return COMPUTED_TORQUE_SOLVED or COMPUTED_TORQUE_WRONG. */
DUAL_NEWTON_API int computed_torque_build(computed_torque *s);

/* Return the last program: over f, or over qdd and f. Rows with positive softness may be violated. */
DUAL_NEWTON_API dual_newton *computed_torque_program(computed_torque *s);

/* Use the solution of any solver. Return COMPUTED_TORQUE_FAILED if it is not a solution. */
DUAL_NEWTON_API int computed_torque_finish(computed_torque *s, const real *x);

#endif
