/* The C core: tree kinematics, muscle paths and their Jacobian, task points.

   No allocation, no global state, no I/O: the caller owns the blob and the working memory.
   Every function of one handle must be called from one thread at a time.                              */
#ifndef CARDSFLOW_CORE_H
#define CARDSFLOW_CORE_H

#include <stddef.h>
#include <stdint.h>

#if defined(CARDSFLOW_INSIDE) /* another library */
#define CORE_API
#elif defined(_WIN32)
#define CORE_API __declspec(dllexport)
#else
#define CORE_API __attribute__((visibility("default")))
#endif

typedef struct core core;

/* The blob's layout as text, a line a count or field; its hash and version, as a blob's header has them. */
CORE_API const char *core_layout(void);
CORE_API uint32_t core_layout_hash(void);
CORE_API uint32_t core_version(void);

/* Bytes of working memory for a robot; 0 if the blob is refused, and `message` says why. */
CORE_API size_t core_size(const void *blob, size_t size, char *message, size_t capacity);

/* Make a handle in `memory`, 8-byte aligned and of core_size bytes, zeroed by this call. The blob must
   outlive it. NULL if the blob is refused.                                                            */
CORE_API core *core_open(const void *blob, size_t size, void *memory);

/* An array by name, and its number of elements; NULL if there is no such array.
     lengths        muscle path lengths l, muscles
     jacobian       L = dl/dq, muscles x dofs, row by row
     torques        -L'f, dofs
     task_values    task coordinates, tasks x 3: see enum task
     task_jacobian  their derivatives by q, tasks x 3 x dofs
     task_bias      J'(q, qd) qd, tasks x 3
     mass_matrix    M(q), dofs x dofs
     coriolis       C(q, qd), dofs
     gravity        G(q), dofs
     q, qd          the state that core_step advances, dofs
     qdd            accelerations, dofs                                                                */
CORE_API double *core_array(core *c, const char *name, size_t *length);

/* damping, lower or upper of the coordinates, dofs, as the blob has them. */
CORE_API const double *core_coordinates(const core *c, const char *field);

/* Go to q: frames, path lengths, muscle Jacobian and task coordinates. */
CORE_API void core_move(core *c, const double *q);

/* Beyond this size, in rad, m or their rates, a state is taken for one that has diverged: engines mask
   overflow, so waiting for an infinity would miss it.                                                 */
#define CORE_LARGEST_STATE 1e9

/* As core_move, after checking that q and qd are numbers within CORE_LARGEST_STATE. 0, or 1 + the index
   of the first coordinate that is not; then nothing is moved.                                         */
CORE_API int core_move_checked(core *c, const double *q, const double *qd);

/* torques = -L'max(f, 0) at the last q: a cable cannot push. 0, or 1 + the index of the first force that
   is not finite; then the torques stay.                                                               */
CORE_API int core_pull(core *c, const double *f);

/* task_jacobian at the last q. */
CORE_API void core_task_jacobian(core *c);

/* task_bias at the last q. */
CORE_API void core_task_bias(core *c, const double *qd);

/* Terms of M qdd + C + G = tau at the last q. */
CORE_API void core_mass_matrix(core *c);
CORE_API void core_coriolis(core *c, const double *qd);
CORE_API void core_gravity(core *c);
/* C + G in the place of `coriolis`. */
CORE_API void core_bias(core *c, const double *qd);

/* qdd of (M + diag(armature)) qdd + C + G = tau at the last q. */
CORE_API void core_accelerate(core *c, const double *qd, const double *tau, const double *armature);

/* Advance q and qd by steps of h with constant muscle forces f and further generalised forces `extra`
   (NULL for none): semi-implicit Euler, M qd' = ..., q' = new qd, with joint damping implicit:
     (M + h D) qdd + C + G = -L'f + extra - D qd
   and joint limits as inelastic stops that are met exactly. 0, or 1 + the index of the first coordinate
   that has diverged; or -1 - the index of the first force that is not finite, before anything moves.   */
CORE_API int core_step(core *c, const double *f, const double *extra, double h, int32_t steps);

#endif
