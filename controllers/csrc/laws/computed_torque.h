/* Control laws through muscle forces: computed torque in joint space, eq. (3) of the CARDSFlow paper, the laws
   of joint/, and computed torque in operational space, eq. (4). What the robot is at a state, M, C + G, L,
   J, J' qd, is written by the caller; these laws know no robot.

   A law is a quadratic program. computed_torque_solve builds it, solves it, and finishes; the three are
   separate calls for callers with a solver of their own:

       status = computed_torque_build(s);
       do {
           ... x from the arrays of computed_torque_program(s) ...
           status = computed_torque_finish(s, x);
       } while (status == COMPUTED_TORQUE_NEXT);
       if (status == COMPUTED_TORQUE_FAILED) status = computed_torque_solve(s);    (x was no solution)

   No allocation, no global state, no I/O: the caller owns the working memory. Every function of one handle
   must be called from one thread at a time.                                                            */
#ifndef CARDSFLOW_COMPUTED_TORQUE_H
#define CARDSFLOW_COMPUTED_TORQUE_H

#include "../qp/dual_newton.h"

typedef struct computed_torque computed_torque;

enum computed_torque_status {
    COMPUTED_TORQUE_SOLVED = 0,
    COMPUTED_TORQUE_SOFT = 1,          /* proven: no forces within the bounds fit; the smallest error */
    COMPUTED_TORQUE_NOT_CONVERGED = 2, /* none were found, and none may or may not fit; the smallest error */
    COMPUTED_TORQUE_FAILED = 3,        /* not even that was found; the forces stay those of the call before */
    COMPUTED_TORQUE_WRONG = 4,         /* a number that was written is not finite or not allowed */
    COMPUTED_TORQUE_NEXT = 5           /* of computed_torque_finish: there is a program of the next priority */
};

/* In the array `law`: the torque is not computed, but is what the array `tau` holds. */
#define COMPUTED_TORQUE_GIVEN (-1)

/* The number of a law in joint space by its name, as in joint/, for the array `law`; -1 if there is none. */
DUAL_NEWTON_API int computed_torque_law(const char *name);

/* Whether the law that the array `law` chooses needs G. */
DUAL_NEWTON_API int computed_torque_needs_gravity(const computed_torque *s);

/* Bytes of working memory for a robot of n coordinates and m muscles, with k task coordinates or, for the
   law in joint space, none; motors of joints count as muscles that may push, with rows of L of their own and
   negative f_min; 0 if a number is too small or too large.                                  */
DUAL_NEWTON_API size_t computed_torque_size(int coordinates, int muscles, int tasks);

/* Make a handle in `memory`, 8-byte aligned and of computed_torque_size bytes, zeroed by this call. NULL if
   the memory or a size is rejected.                                                                    */
DUAL_NEWTON_API computed_torque *computed_torque_open(int coordinates, int muscles, int tasks,
                                                      void *memory);

/* An array by name, and its number of elements; NULL if there is no such array. r is the number of rows of
   the reference: n in joint space, k in operational space.
   To be written at every call:
     M, h, L               mass matrix n x n; C + G + D qd, n; muscle Jacobian, m x n
     G                     gravity, n; for laws that need it: see computed_torque_needs_gravity
     load                  known generalised load on the left of the motion equation, n
     error, rate_error     of the reference, r: its position less the robot's, likewise its velocity
     acceleration          of the reference, r
     correction            added to the commanded acceleration, or torque, r
     q, qd                 n; qd in joint space for torque_position
     J, bias               task Jacobian k x n; J' qd, k; in operational space
     tau                   n; where the law is COMPUTED_TORQUE_GIVEN. Of other laws: their torque
   To be written before:
     law                   1: see computed_torque_law; in joint space
     kp, kd                r
     f_min, f_max          m
     H_f                   cost of the forces, m
     f_p                   pretension, m
     norm                  1; in joint space: which of H_f^1/2 (f - f_p) is least, 1 to 8 or infinite; 0 for 2
     passive               n; 1 for coordinates that follow nothing, in joint space
     tolerance             1; in joint space: largest torque that may lack, relative to 1 + max |tau|; 0 for 1e-6
   and in operational space
     H_q, H_r              cost of accelerations, n, and of changes of forces, m
     W                     weights of the tasks, k; infinite for one that is to be met exactly
     priority              rank of each task, k: a lower one is met first, whatever it costs those of higher rank
     posture_kp, posture_kd, q0           n
     q_min, q_max          n; infinite if there is no limit
     limit_bandwidth       1; 0 to leave the limits to the robot
   Results:
     forces                m
     slack                 what is missing, r: torque in joint space, acceleration in operational space
     qdd                   accelerations that the forces make, n; in operational space
     limits_dropped        1: whether joint limits had to be left out
   Memory between calls, to be saved and restored for the same answers bit for bit:
     memory                                                                                             */
DUAL_NEWTON_API real *computed_torque_array(computed_torque *s, const char *name, size_t *length);

/* Forget the calls before: warm starts, and last forces, which become the smallest within their bounds. */
DUAL_NEWTON_API void computed_torque_reset(computed_torque *s);

/* The forces; an enum computed_torque_status. */
DUAL_NEWTON_API int computed_torque_solve(computed_torque *s);

/* Write tau of the law in joint space. */
DUAL_NEWTON_API void computed_torque_require(computed_torque *s);

/* Build the program, of the first priority; COMPUTED_TORQUE_SOLVED or COMPUTED_TORQUE_WRONG. */
DUAL_NEWTON_API int computed_torque_build(computed_torque *s);

/* What was built: over f, or over qdd and f. Rows of a positive softness may give way. */
DUAL_NEWTON_API dual_newton *computed_torque_program(computed_torque *s);

/* Take an answer of any solver; COMPUTED_TORQUE_FAILED if it is not one. */
DUAL_NEWTON_API int computed_torque_finish(computed_torque *s, const real *x);

/* Build, in its place, the program that always has a solution: in joint space the smallest error of M^-1 tau,
   over f. COMPUTED_TORQUE_SOLVED or COMPUTED_TORQUE_WRONG.                                             */
DUAL_NEWTON_API int computed_torque_build_soft(computed_torque *s);

#endif
