/* The C core: tree kinematics, dynamics, muscle paths and their Jacobian, task coordinates.

   The core does not allocate memory, has no global state and no I/O: the caller owns the blob and the
   working memory. Every function of one handle must be called from one thread at a time. */
#ifndef CARDSFLOW_CORE_H
#define CARDSFLOW_CORE_H

#include "numbers/real.h"

#include <stddef.h>
#include <stdint.h>

#if IS_ONE_UNIT
#define CORE_API CORE_INSIDE
#elif defined(CARDSFLOW_INSIDE) /* defined in another library */
#define CORE_API
#elif defined(_WIN32)
#define CORE_API __declspec(dllexport)
#else
#define CORE_API __attribute__((visibility("default")))
#endif

typedef struct core core;

/* Return the layout of the blob as text, one line per count or field; the muscle laws, one line each with
   the parameters in order; the hash of both and the version, as in the header of a blob. */
CORE_API const char *core_layout(void);
CORE_API const char *core_laws(void);
CORE_API uint32_t core_layout_hash(void);
CORE_API uint32_t core_version(void);

/* Return the size in bytes of the working memory for a robot; 0, with a message, if the blob is rejected. */
CORE_API size_t core_size(const void *blob, size_t size, char *message, size_t capacity);

/* Create a handle in `memory`, which is 8-byte aligned and has core_size bytes; this call sets it to zero.
   The blob must outlive the handle. Return NULL if the blob is rejected. */
CORE_API core *core_open(const void *blob, size_t size, void *memory);

/* Return an array by name, and its number of elements; NULL if the array does not exist.

     lengths        muscle path lengths l, muscles
     jacobian       L = dl/dq, muscles x dofs, row by row
     torques        -L'f, dofs
     task_values    task coordinates, tasks x 3: see enum task
     task_jacobian  their derivatives by q, tasks x 3 x dofs
     task_bias      J'(q, qd) qd, tasks x 3
     closure_gap    gaps of loop joints, zero if a loop is closed, closures
     closure_jacobian  derivative J of the gaps by q, closures x dofs
     closure_bias   J'(q, qd) qd, closures
     mass_matrix    M(q), dofs x dofs
     coriolis       C(q, qd), dofs
     gravity        G(q), dofs
     q, qd          state that core_step advances, dofs
     qdd            accelerations, dofs
     held           -1 for coordinates held at the lower limit, 1 at the upper limit, otherwise 0; the caller may
                    write them, dofs
     hold_force     see core_derivative, dofs
     outer          external generalised forces at the last evaluation of a step, dofs
     work           work during the last step, in [J]: of muscles, external forces, damping, cable friction; 4
     energies       energies in [J]: kinetic; potential energy of gravity, zero at the origin of the world; of
                    the springs of joints; 3
     momenta        linear momentum in [N s], angular momentum about the origin of the world in [N m s]; 6
   Moving frames, in the world:
     frame_rotation rotation matrix, row by row, frames x 9
     frame_origin   origin, which lies on the axis, frames x 3
     frame_axis     axis of the motion, frames x 3
   Paths:
     points         via points in the world, points x 3
     surface_places centre and z axis of each surface in the world, surfaces x 6
     surface_across x axis of each ellipsoid in the world, surfaces x 3
     wrap_contacts, pulley_contacts    see core_trace
     wrap_before    via point before each wrap, -1 if the wrap is inactive, wraps; wrap_rank is the rank among
                    the wraps between the same points, wraps
     point_share    activity of each via point in its path, 0 to 1: see routed.c
   Muscle laws:
     rates          l' = L qd, muscles
     tension_scale  factor on the tension of each muscle, initially 1; 0: the cable is cut; the caller may write it,
                    muscles
     tensions       f, muscles; negative only for springs that push
     law_states     states of the laws, muscle after muscle; then, for each bend of cables with friction, the
                    stretch if the cable stretches (cable_stretch.c), then s (cable_friction.c); the caller may
                    write them
     far_tensions   tensions at the last via points, with friction, muscles; absent without cable friction
     bend_flow, bend_grip   of each bend: derivative of the sliding distance by the coordinates, bends x dofs; mu
                    times the angle, bends
     pull_jacobian  see core_pulling
     law_rates      time derivatives of law_states
     force_low      minimum reachable tension, muscles
     force_high     maximum reachable tension, muscles
     commands       commands computed by core_invert, muscles */
CORE_API real *core_array(core *c, const char *name, size_t *length);

/* Return damping, friction, lower or upper of the coordinates q, dofs, as in the blob. */
CORE_API const real *core_coordinates(const core *c, const char *field);

/* Move to q: compute frames, path lengths, muscle Jacobian and task coordinates. */
CORE_API void core_move(core *c, const real *q);

/* A state beyond this size, in rad, m or their rates, has diverged. Engines mask overflow, so a test for
   infinity would miss it. */
#define CORE_MAX_STATE 1e9

/* Do the same as core_move, after checking that q and qd are finite and within CORE_MAX_STATE. Return 0,
   or 1 + the index of the first invalid coordinate; in this case nothing changes. */
CORE_API int core_move_checked(core *c, const real *q, const real *qd);

/* Compute torques = -L'max(f, 0) at the last q, since a cable cannot push. Return 0, or 1 + the index of the
   first force that is not finite; in this case the torques do not change. */
CORE_API int core_pull(core *c, const real *f);

/* Compute wrap_contacts and pulley_contacts at the last q, 22 values each, in the world: the point at which
   the incoming span pulls the body, and the direction of the span towards it; the same for the outgoing
   span; begin and end of the contact; the axis about which the cable turns; the angle of contact in [rad], 0
   if the cable does not touch. A contact with an ellipsoid has no axis, and has its length in [m] instead of
   the angle.

   A cable with the tension f pulls a surface with -f and f times the two directions. */
CORE_API void core_trace(core *c);

/* Write a polyline along each muscle at the last q, for drawing: one after the other, as far as `capacity`
   points, 3 numbers each, and their numbers of points to `sizes`, muscles. Return the number of all points. */
CORE_API int32_t core_lines(core *c, int32_t *sizes, real *points, int32_t capacity);

/* Compute task_jacobian at the last q. */
CORE_API void core_task_jacobian(core *c);

/* Compute task_bias at the last q. */
CORE_API void core_task_bias(core *c, const real *qd);

/* Compute a term of M qdd + C + G = tau at the last q. G contains gravity and the springs of joints, and
   about half the weight of heavy cables at either end. */
CORE_API void core_mass_matrix(core *c);
CORE_API void core_coriolis(core *c, const real *qd);
CORE_API void core_gravity(core *c);
/* Compute C + G in `coriolis`. */
CORE_API void core_bias(core *c, const real *qd);

/* Compute energies and momenta at the last q. */
CORE_API void core_energies(core *c, const real *qd);

/* Compute closure_gap, closure_jacobian, and closure_bias at qd, at the last q. */
CORE_API void core_closures(core *c, const real *qd);

/* Compute free_motion, N, dofs x dofs, and free_bias, c, dofs, of qdd = N qdd + c at the last q. Coordinates
   with a nonzero `dependent` follow from the others; their columns of N are 0. Do nothing if the robot has
   no loops. Return 0, or 1 + the index of a coordinate that does not follow from the others at this q. */
CORE_API int core_free_motion(core *c, const real *dependent, const real *qd);

/* Reduce terms of the motion equation to independent coordinates, with the N and c of the last
   core_free_motion; see independent.c. Rows and columns of dependent coordinates become 0. Do nothing if the
   robot has no loops.

     rows     rows N, for rows of dofs: L, J, generalised forces
     bias     values += rows c: of M, h; of J, J' qd
     mass     N'M N, and 1 for dependent coordinates
     complete N qdd + c */
CORE_API void core_independent_rows(core *c, int32_t count, real *rows);
CORE_API void core_independent_bias(core *c, int32_t count, const real *rows, real *values);
CORE_API void core_independent_mass(core *c, const real *dependent, real *M);
CORE_API void core_complete(core *c, real *qdd);

/* Close the gaps of all loops: change q, dofs, within the limits, except the coordinates with nonzero `held`
   (NULL: none). Return 0; the handle has then moved to q if loops exist. Otherwise return 1 + the index of
   the closure with the largest gap; q is then the best approximation. A q without gaps does not change. */
CORE_API int core_close(core *c, const real *held, real *q);

/* Change qd, dofs, by the smallest impulses that keep the loops closed, at the last q. */
CORE_API void core_close_rates(core *c, real *qd);

/* Compute qdd of M qdd + C + G = tau + J'p at the last q, with p such that loops stay closed. G is gravity
   only. M has the given armatures, one value per variable, instead of those of the robot. */
CORE_API void core_accelerate(core *c, const real *qd, const real *tau, const real *armature);

/* Advance q, qd and law_states by steps of h with constant commands u (the command of an ideal cable is its
   force) and external generalised forces `extra` (NULL for none). The integrator is semi-implicit Euler,
   with implicit damping and springs of joints:

     (M + h D + h^2 K) qdd + C + G = -L'f + extra - D qd - K (q + h qd - rest)

   G is gravity only. Coulomb friction of joints stops and holds them exactly. Joint limits are inelastic
   stops that are hit exactly. Both are solved together with the loop joints, whose gaps phi close within the
   step, J qd = -phi / h. A coordinate that starts beyond a limit returns with at most 10 rad/s or m/s.
   Return 0; or 1 + the index of the first coordinate that diverged, dofs + 1 for the state of a muscle; or
   -1 - the index of the first command that is not finite, before anything moves. */
CORE_API int core_step(core *c, const real *u, const real *extra, real h, int32_t steps);

/* Do the same as core_step with the fourth-order Runge-Kutta method: damping, springs and the states of the
   laws are explicit. Robots with Coulomb friction are not supported, since an explicit method cannot hold a
   stop. A coordinate beyond a limit is set to the limit at the end of the step, and stopped by an impulse.
   Loops stay closed by accelerations; remaining gaps are closed at the end of the step. After a failure the
   state is somewhere within the step. */
CORE_API int core_runge_kutta(core *c, const real *u, const real *extra, real h, int32_t steps);

/* In continuous time: compute qdd, law_rates, and in `work` the power, in [W], at the last q, at qd and
   law_states. Coordinates that are `held` have no acceleration; their limits push with a positive
   `hold_force`, in [N m] or [N], until they are released. Other coordinates move as without limits. Return 0,
   or 1 + the index of the first muscle whose command is not finite. */
CORE_API int core_derivative(core *c, const real *u, const real *extra);

/* At an event at the last q: close the loops, set coordinates beyond a limit to the limit, stop them by
   inelastic impulses, and compute `held`. Return the same as core_derivative. */
CORE_API int core_meet_limits(core *c, const real *u, const real *extra);

/* Set the wrenches that act in all following steps: on the point `point` (3) of frame `frame`, -1 for the
   world, a force and a moment (6), in world axes. The caller owns the arrays and may write the wrenches
   between steps. Return 0; or 1 + the index of the first frame that does not exist, and nothing changes. */
CORE_API int core_external_wrenches(core *c, int32_t count, const int32_t *frame, const real *point,
                                    const real *wrench);

/* ---- Muscle laws, all at the last q. u has one command per muscle, in the unit of its law. A command
   outside the range of the law is clamped to it; the command of a passive muscle has no effect. Functions
   that return int return 0, or 1 + the index of the first muscle whose command is not finite; in this case
   nothing changes. ---- */

/* Compute rates = L qd. */
CORE_API void core_rates(core *c, const real *qd);

/* Compute the steady law_states of a muscle at rest with command u. */
CORE_API int core_start(core *c, const real *u);

/* Compute rates at qd, tensions from rates and law_states, and torques = -L'tensions. */
CORE_API int core_drive(core *c, const real *qd, const real *u);

/* For cables with friction at the last q: compute the states of the bends after a displacement `way`, dofs;
   or pull_jacobian, muscles x dofs, the equivalent of L for the current states: torques = -P'f. Do nothing
   without cable friction. */
CORE_API void core_slide(core *c, const real *way);
CORE_API void core_pulling(core *c);

/* Compute law_rates at rates and law_states. */
CORE_API int core_law_rates(core *c, const real *u);

/* Advance law_states by a time h [s] with constant u, while each path lengthens with its rate. A caller that
   has computed the velocities at the end of the step calls core_rates with them first. */
CORE_API int core_advance(core *c, const real *u, real h);

/* Compute force_low and force_high: the tensions after a time h with the minimum and maximum command, while
   each path lengthens with its rate. Laws without states act at once; their current tensions are used.
   law_states do not change. If a tension decreases with the command, force_low is still the smaller one. */
CORE_API void core_reach(core *c, real h);

/* Compute commands: those after which the tensions of core_reach are f, or as close to f as possible. A
   position command is assumed to move along with its path after every time `hold`, above 0. f must be
   finite; return 0, or 1 + the index of the first force that is not. */
CORE_API int core_invert(core *c, const real *f, real h, real hold);

/* Evaluate the fibres and tendons of Hill-type muscles at `count` points, independently of the state of the
   handle. A point has 5 numbers for each muscle: activation, fibre length in [m], fibre velocity in [m/s],
   path length in [m], activation rate in [1/s]; points x muscles x 5. The result has 14 numbers:
     0   force of the fibre along the tendon in [N]; 1, 2, 3 its derivatives by activation, fibre length, fibre
         velocity
     4   force of the tendon in [N]; 5 its derivative by the fibre length
     6   factors of active force-length, 7 force-velocity, 8 passive force-length; 9 cosine of the pennation
     10  excitation that changes the activation at its rate; 11, 12 its derivatives by activation and rate
     13  the fibre length, or the shortest fibre length if it is longer
   Numbers of other muscles do not change. */
CORE_API void core_fibres(const core *c, int32_t count, const real *points, real *values);
/* Compute the fibre lengths with given tensions of Hill-type muscles. A point has 2 numbers for each muscle:
   tension over maximum isometric force, above 0, and path length in [m]; the result has 2: fibre length in
   [m] and its derivative by the first number. */
CORE_API void core_tendons(const core *c, int32_t count, const real *points, real *values);
/* Evaluate a curve of a muscle law at x, or its slope: active_force_length, force_velocity,
   passive_force_length, tendon_force_length. Lengths are relative to the optimal fibre length or the tendon
   slack length; velocities are relative to the maximum contraction velocity, positive while lengthening.
   Return NaN if the law does not have this curve. */
CORE_API real core_curve(const core *c, int32_t muscle, const char *curve, real x, int slope);

#endif
