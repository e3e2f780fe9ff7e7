/* Computed torque through muscle forces: eq. (3), in joint space, and eq. (4), in operational space, of the
   CARDSFlow paper. What the robot is at a state, M, C + G, L, J, J' qd, is written by the caller; these laws
   know no robot.

   No allocation, no global state, no I/O: the caller owns the working memory. Every function of one handle
   must be called from one thread at a time.                                                            */
#ifndef CARDSFLOW_COMPUTED_TORQUE_H
#define CARDSFLOW_COMPUTED_TORQUE_H

#include "../dual_newton/dual_newton.h"

typedef struct computed_torque computed_torque;

enum computed_torque_status {
    COMPUTED_TORQUE_SOLVED = 0,
    COMPUTED_TORQUE_SOFT = 1,          /* proven: no forces within the bounds fit; the smallest error */
    COMPUTED_TORQUE_NOT_CONVERGED = 2, /* none were found, and none may or may not fit; the smallest error */
    COMPUTED_TORQUE_FAILED = 3,        /* not even that was found; the forces stay those of the call before */
    COMPUTED_TORQUE_WRONG = 4          /* a number that was written is not finite or not allowed */
};

/* Bytes of working memory for a robot of n coordinates and m muscles, with k task coordinates or, for the
   law in joint space, none; motors of joints count as muscles that may push, with rows of L of their own and
   negative f_min; 0 if a number is too small or too large.                                  */
DUAL_NEWTON_API size_t computed_torque_size(int coordinates, int muscles, int tasks);

/* Make a handle in `memory`, 8-byte aligned and of computed_torque_size bytes, zeroed by this call. NULL if
   the memory or a size is refused.                                                                    */
DUAL_NEWTON_API computed_torque *computed_torque_open(int coordinates, int muscles, int tasks,
                                                      void *memory);

/* An array by name, and its number of elements; NULL if there is no such array. r is the number of rows of
   the reference: n in joint space, k in operational space.
   To be written at every call:
     M, h, L               mass matrix n x n; C + G + D qd + loads, n; muscle Jacobian, m x n
     error, rate_error     of the reference, r: its position less the robot's, likewise its velocity
     acceleration          of the reference, with what is to be added to it, r
     q, qd                 n; in operational space
     J, bias               task Jacobian k x n; J' qd, k; in operational space
   To be written before:
     kp, kd                r
     f_min, f_max          m
     H_f                   cost of the forces, m
     f_p                   pretension, m
     norm                  1; in joint space: which is least, 3 to 8, or 2 and below for the second
     passive               n; 1 for coordinates that follow nothing, in joint space
   and in operational space
     H_q, H_r              cost of accelerations, n, and of changes of forces, m
     W                     weights of the tasks, k; infinite for one that is to be met exactly
     posture_kp, posture_kd, q0           n
     q_min, q_max          n; infinite where there is no limit
     limit_bandwidth       1; 0 to leave the limits to the robot
   Results:
     forces                m
     slack                 what is missing, r: torque in joint space, acceleration in operational space
     limits_dropped        1: whether joint limits had to be left out
   Memory between calls, to be saved and restored for the same answers bit for bit:
     memory                                                                                             */
DUAL_NEWTON_API real *computed_torque_array(computed_torque *s, const char *name, size_t *length);

/* Forget the calls before: warm starts, and last forces, which become the smallest within their bounds. */
DUAL_NEWTON_API void computed_torque_reset(computed_torque *s);

/* The forces; an enum computed_torque_status. */
DUAL_NEWTON_API int computed_torque_solve(computed_torque *s);

#endif
