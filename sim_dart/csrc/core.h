/* The C core: tree kinematics, muscle paths and their Jacobian, task points.

   No allocation, no global state, no I/O: the caller owns the blob and the working memory.
   Every function of one handle must be called from one thread at a time.                              */
#ifndef CARDSFLOW_CORE_H
#define CARDSFLOW_CORE_H

#include "numbers/real.h"

#include <stddef.h>
#include <stdint.h>

#if defined(CARDSFLOW_TANGENT)
#define CORE_API CORE_INSIDE
#elif defined(CARDSFLOW_INSIDE) /* another library */
#define CORE_API
#elif defined(_WIN32)
#define CORE_API __declspec(dllexport)
#else
#define CORE_API __attribute__((visibility("default")))
#endif

typedef struct core core;

/* The blob's layout as text, a line a count or field; the muscle laws, a line each with its parameters
   in order; the hash of both and the version, as a blob's header has them.                            */
CORE_API const char *core_layout(void);
CORE_API const char *core_laws(void);
CORE_API uint32_t core_layout_hash(void);
CORE_API uint32_t core_version(void);

/* Bytes of working memory for a robot; 0 if the blob is rejected, and `message` says why. */
CORE_API size_t core_size(const void *blob, size_t size, char *message, size_t capacity);

/* Make a handle in `memory`, 8-byte aligned and of core_size bytes, zeroed by this call. The blob must
   outlive it. NULL if the blob is rejected.                                                            */
CORE_API core *core_open(const void *blob, size_t size, void *memory);

/* An array by name, and its number of elements; NULL if there is no such array.
     lengths        muscle path lengths l, muscles
     jacobian       L = dl/dq, muscles x dofs, row by row
     torques        -L'f, dofs
     task_values    task coordinates, tasks x 3: see enum task
     task_jacobian  their derivatives by q, tasks x 3 x dofs
     task_bias      J'(q, qd) qd, tasks x 3
     closure_gap    of loop joints: what is to be zero, closures
     closure_jacobian  its derivative J by q, closures x dofs
     closure_bias   J'(q, qd) qd, closures
     mass_matrix    M(q), dofs x dofs
     coriolis       C(q, qd), dofs
     gravity        G(q), dofs
     q, qd          the state that core_step advances, dofs
     qdd            accelerations, dofs
     outer          generalised external forces at the last evaluation of a step, dofs
     work           done by the last call that steps, in [J]: of muscles, from outside, of damping, of cables'
                    friction; 4
     energies       of what moves, in [J]: kinetic, of its weight, zero at the world's origin, of the
                    joints' springs; 3
     momenta        of what moves: linear in [N s], angular about the world's origin in [N m s]; 6
   Of the frames that move, in the world:
     frame_rotation row by row, frames x 9
     frame_origin   on the axis, frames x 3
     frame_axis     of its motion, frames x 3
   Of the paths:
     points         via points in the world, points x 3
     surface_places a surface's centre and z axis in the world, surfaces x 6
     surface_across an ellipsoid's x axis in the world, surfaces x 3
     wrap_contacts, pulley_contacts    see core_trace
     wrap_before    via point before each wrap, -1 if it is in no use; wrap_rank its place among
                    those between the same points, wraps
     point_share    of each via point in its path, 0 to 1: see routed.c
     wrap_turning   turning angles about cylinders while turns are counted, in [rad], wraps; the caller
                    may write them back
   Of the muscle laws:
     rates          l' = L qd, muscles
     tensions       f, muscles; never negative but for springs that push
     law_states     what the laws remember, muscle after muscle; behind it of each bend of cables with friction
                    the stretch, where they stretch all along (cable_stretch.c), then s (cable_friction.c); the caller
                    may write them
     far_tensions   what friction makes of them at the last via points, muscles; none without friction
     bend_flow, bend_grip   of each bend: how fast the cable slides in it with the coordinates, bends x dofs; mu
                    times the angle, bends
     pull_jacobian  see core_pulling
     law_rates      their time derivatives
     force_low      smallest tension in reach, muscles
     force_high     largest tension in reach, muscles
     commands       found by core_invert, muscles                                                      */
CORE_API real *core_array(core *c, const char *name, size_t *length);

/* damping, friction, lower or upper of the coordinates q, dofs, as the blob has them. */
CORE_API const real *core_coordinates(const core *c, const char *field);

/* Go to q: frames, path lengths, muscle Jacobian and task coordinates. */
CORE_API void core_move(core *c, const real *q);

/* Beyond this size, in rad, m or their rates, a state is taken for one that has diverged: engines mask
   overflow, so waiting for an infinity would miss it.                                                 */
#define CORE_LARGEST_STATE 1e9

/* As core_move, after checking that q and qd are numbers within CORE_LARGEST_STATE. 0, or 1 + the index
   of the first coordinate that is not; then nothing is moved.                                         */
CORE_API int core_move_checked(core *c, const real *q, const real *qd);

/* torques = -L'max(f, 0) at the last q: a cable cannot push. 0, or 1 + the index of the first force that
   is not finite; then the torques stay.                                                               */
CORE_API int core_pull(core *c, const real *f);

/* wrap_contacts and pulley_contacts at the last q, 22 numbers each, in the world: the point where a span
   pulls at the body and the span's direction towards it; the same of the span that leaves; where the
   contact begins and ends; the axis that it turns about; its angle in [rad], 0 where the cable runs free. Over an ellipsoid there
   is no axis, and the length of the contact in [m] is in the angle's place.
   A cable with the tension f pulls at a surface with -f and f times the two directions.               */
CORE_API void core_trace(core *c);

/* Have wraps over cylinders remember how often they have turned, from the next move on, or forget it. The
   next move begins with the turns that the robot states; each one after must turn by less than half.   */
CORE_API void core_count_turns(core *c, int on);

/* task_jacobian at the last q. */
CORE_API void core_task_jacobian(core *c);

/* task_bias at the last q. */
CORE_API void core_task_bias(core *c, const real *qd);

/* Terms of M qdd + C + G = tau at the last q; G is the weight's and the joints' springs', and of heavy cables
   about half their weight at either end. */
CORE_API void core_mass_matrix(core *c);
CORE_API void core_coriolis(core *c, const real *qd);
CORE_API void core_gravity(core *c);
/* C + G in the place of `coriolis`. */
CORE_API void core_bias(core *c, const real *qd);

/* energies and momenta at the last q. */
CORE_API void core_energies(core *c, const real *qd);

/* closure_gap and closure_jacobian, and closure_bias at qd, at the last q. */
CORE_API void core_closures(core *c, const real *qd);

/* free_motion, N, dofs x dofs, and free_bias, c, dofs, of qdd = N qdd + c at the last q, where the coordinates
   whose `dependent` is not 0 follow from the others; those columns of N are 0. Nothing without loops.
   0, or 1 + the index of a coordinate that does not follow from the others here.                       */
CORE_API int core_free_motion(core *c, const real *dependent, const real *qd);

/* Terms of the motion equation by independent coordinates, in the place of those of all, by the N and c of the
   last core_free_motion; see independent.c. Rows and columns of dependent coordinates are 0. Nothing without loops.
     rows     rows N, for rows of dofs: L, J, generalised forces
     bias     values += rows c: of M, h; of J, J' qd
     mass     N'M N, and 1 for dependent coordinates
     complete N qdd + c                                                                                 */
CORE_API void core_independent_rows(core *c, int32_t count, real *rows);
CORE_API void core_independent_bias(core *c, int32_t count, const real *rows, real *values);
CORE_API void core_independent_mass(core *c, const real *dependent, real *M);
CORE_API void core_complete(core *c, real *qdd);

/* Close the gaps of all loops: change q, dofs, but the coordinates whose `held` is not 0 (NULL: none), within
   the limits. 0, and where there are loops the handle has moved there; or 1 + the index of the closure with the largest gap, where
   q is as near as it gets. A q without gaps stays as it is.                                            */
CORE_API int core_close(core *c, const real *held, real *q);

/* Change qd, dofs, as little as the loops ask for, by impulses at the last q. */
CORE_API void core_close_rates(core *c, real *qd);

/* qdd of M qdd + C + G = tau + J'p at the last q, with p such that loops stay closed, where G is the weight's alone, and M has these armatures, a number
   for each variable, in the place of the robot's own.                                                  */
CORE_API void core_accelerate(core *c, const real *qd, const real *tau, const real *armature);

/* Advance q, qd and law_states by steps of h with constant commands u (of an ideal cable its force) and
   further generalised forces `extra` (NULL for none): semi-implicit Euler, with the joints' damping and
   springs implicit:
     (M + h D + h^2 K) qdd + C + G = -L'f + extra - D qd - K (q + h qd - rest)
   (here G is the weight's alone), Coulomb friction of joints, which stops and holds them exactly, and joint
   limits as inelastic stops that are met exactly, all in one problem with the loop joints, whose gaps phi
   close within the step, J qd = -phi / h; a coordinate
   that starts beyond one comes back to it by 10 rad/s or m/s at most. 0; or 1 + the
   index of the first coordinate that has diverged, dofs + 1 for a muscle's state; or -1 - the index of the
   first command that is not finite, before anything moves.                                            */
CORE_API int core_step(core *c, const real *u, const real *extra, real h, int32_t steps);

/* As core_step, by Runge and Kutta's rule of fourth order: damping, springs and the laws' states as well
   are explicit. Not for robots with Coulomb friction, of which it knows nothing: no explicit rule holds a
   stop. A coordinate that has passed a limit is put back to it at the end of the step, and stopped
   by an impulse. Loops stay closed by accelerations, and what is left of gaps is closed at the end of the step.
   After a failure the state is somewhere within the step.                               */
CORE_API int core_runge_kutta(core *c, const real *u, const real *extra, real h, int32_t steps);

/* Wrenches that act from now on in every step: on the point `point` (3) of frame `frame`, -1 for the world,
   a force and a moment (6), in world axes. The arrays are the caller's, who may write the wrenches between
   steps. 0; or 1 + the index of the first frame that there is not, and nothing changes.                */
CORE_API int core_external_wrenches(core *c, int32_t count, const int32_t *frame, const real *point,
                       const real *wrench);

/* ---- Muscle laws, all at the last q. u has a command a muscle, in the unit of its law; a command beyond
   the law's range acts as the nearest one in it, that of a passive muscle has no effect. Those that
   return int return 0, or 1 + the index of the first muscle whose command is not finite; then nothing
   has changed. ---- */

/* rates = L qd. */
CORE_API void core_rates(core *c, const real *qd);

/* law_states of a muscle that has been at rest with u for long. */
CORE_API int core_start(core *c, const real *u);

/* rates at qd; tensions at them and law_states; torques = -L'tensions. */
CORE_API int core_drive(core *c, const real *qd, const real *u);

/* Of cables with friction, at the last q: the bends' states after a way dq, dofs, and pull_jacobian, muscles x dofs,
   in the place of L as the states have it: torques = -P'f. Neither does anything without friction.       */
CORE_API void core_slide(core *c, const real *way);
CORE_API void core_pulling(core *c);

/* law_rates at rates and law_states. */
CORE_API int core_law_rates(core *c, const real *u);

/* law_states after a time h [s] with constant u, each path lengthening with its rate. A caller that knows
   the velocities at the end of the step calls core_rates with them first.                             */
CORE_API int core_advance(core *c, const real *u, real h);

/* force_low, force_high: the tensions after a time h with the smallest and the largest command, each path
   lengthening with its rate. Laws without states act at once: theirs are the tensions of now. The
   law_states stay. Also for a tension that falls with the command, low is the smaller one.            */
CORE_API void core_reach(core *c, real h);

/* commands: those that have the tensions of core_reach come to f, or as near to it as they can. A position
   is expected to move along with its path after every time `held`, above 0. f must be finite; 0, or 1 + the
   index of the first that is not.                                                                     */
CORE_API int core_invert(core *c, const real *f, real h, real held);

/* A curve of a muscle's law at x, or its slope: active_force_length, force_velocity, passive_force_length,
   tendon_force_length; lengths over the optimal fibre's or the tendon's slack length, velocities over
   the largest contraction velocity, positive while lengthening. NaN if the law has no such curve.     */
CORE_API real core_curve(const core *c, int32_t muscle, const char *curve, real x, int slope);

#endif
