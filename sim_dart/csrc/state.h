/* The inside of a handle, and the small vector algebra. */
#ifndef CARDSFLOW_STATE_H
#define CARDSFLOW_STATE_H

#include "core.h"
#include "layout.h"
#include "real_functions.h"

/* ARRAY(name, number of doubles) in the working memory behind the handle.
   A rotation about a constant axis is R0 + sin(q) R1 + (1 - cos(q)) R2, with R1 = R0 [a], R2 = R0 [a][a]. */
#define STATE_ARRAYS(ARRAY)                                                                            \
    ARRAY(rotation_sin, 9 * dofs)                                                                      \
    ARRAY(rotation_cos, 9 * dofs)                                                                      \
    ARRAY(rotation, 9 * dofs) /* frame in the world, row by row */                                     \
    ARRAY(origin, 3 * dofs)   /* of the frame in the world; on the axis */                             \
    ARRAY(axis, 3 * dofs)     /* in the world */                                                       \
    ARRAY(point, 3 * points)  /* via points in the world */                                            \
    ARRAY(link, 3 * dofs)     /* from the parent frame's origin to this one's, in the world */         \
    ARRAY(spin, 3 * dofs)     /* angular velocity of the frame, in the world */                        \
    ARRAY(slide, 3 * dofs)    /* what the motion's own velocity is: axis * qd */                       \
    ARRAY(velocity, 3 * dofs) /* of the origin */                                                      \
    ARRAY(centre, 3 * dofs)   /* first moment of mass about the origin, m r */                         \
    ARRAY(moment, 9 * dofs)   /* second moment: inertia about the origin */                            \
    ARRAY(drift, 6 * dofs)    /* acceleration of the frame beyond the parent's, at qdd = 0 */          \
    ARRAY(acceleration, 6 * dofs)                                                                      \
    ARRAY(wrench, 6 * dofs)   /* moment about the origin, force */                                     \
    ARRAY(articulated, 27 * dofs)                                                                      \
    ARRAY(reaction, 6 * dofs)                                                                          \
    ARRAY(pivot, dofs)                                                                                 \
    ARRAY(drive, dofs)                                                                                 \
    ARRAY(mass_matrix, dofs *dofs)                                                                     \
    ARRAY(coriolis, dofs)                                                                              \
    ARRAY(gravity, dofs)                                                                               \
    ARRAY(qdd, dofs)                                                                                   \
    ARRAY(at, dofs)           /* q of the last move */                                                 \
    ARRAY(q, dofs)            /* where the robot is */                                                 \
    ARRAY(qd, dofs)                                                                                    \
    ARRAY(load, dofs)         /* generalised forces of a step */                                       \
    ARRAY(outer, dofs)        /* those from outside */                                                 \
    ARRAY(work, 3)            /* of muscles, of what acts from outside, of damping */                  \
    ARRAY(energies, 3)        /* kinetic, of the weight, of springs */                                 \
    ARRAY(momenta, 6)         /* linear, angular */                                                    \
    ARRAY(before, 2 * dofs + law_states) /* q, qd, law_states at the step's beginning */               \
    ARRAY(slopes, 2 * dofs + law_states) /* sum of their rates over the stages */                      \
    ARRAY(armature, dofs)                                                                              \
    ARRAY(response, dofs *dofs) /* rows: what a unit impulse on a coordinate does to qd */             \
    ARRAY(factor, dofs *dofs)                                                                          \
    ARRAY(impulse, dofs)                                                                               \
    ARRAY(low, dofs)          /* velocities that limits leave */                                       \
    ARRAY(high, dofs)                                                                                  \
    ARRAY(target, dofs)                                                                                \
    ARRAY(free, dofs)         /* velocities without any limit */                                       \
    ARRAY(met, dofs)          /* indices of coordinates at a limit */                                  \
    ARRAY(grip, dofs)         /* the largest impulse of friction */                                    \
    ARRAY(unbraked, dofs)     /* velocities without limits and friction */                             \
    ARRAY(slides, dofs)       /* 0 if it is held; else -1 below 0, if it rubs, 1 above */              \
    ARRAY(sliding, dofs)      /* velocities found so far */                                            \
    ARRAY(side, dofs)         /* -1 at its lower limit, 1 at its upper one, 0 elsewhere */             \
    ARRAY(task_bias, 3 * tasks)                                                                        \
    ARRAY(lengths, muscles)                                                                            \
    ARRAY(jacobian, muscles *dofs)                                                                     \
    ARRAY(torques, dofs)                                                                               \
    ARRAY(task_values, 3 * tasks)                                                                      \
    ARRAY(task_jacobian, 3 * tasks *dofs)                                                              \
    ARRAY(rates, muscles)                                                                              \
    ARRAY(tensions, muscles)                                                                           \
    ARRAY(law_states, law_states)                                                                      \
    ARRAY(law_rates, law_states)                                                                       \
    ARRAY(law_constants, law_constants) /* what a law makes of its parameters once */                  \
    ARRAY(force_low, muscles)                                                                          \
    ARRAY(force_high, muscles)                                                                         \
    ARRAY(commands, muscles)                                                                           \
    ARRAY(surface_place, 6 * surfaces) /* centre and axis in the world */                              \
    ARRAY(wrap_radius, wraps)          /* of the surface, in the order of the wraps; and what follows */  \
    ARRAY(wrap_half, wraps)            /* infinite where there are no ends */                          \
    ARRAY(wrap_has_axis, wraps)        /* 1 for a cylinder, 0 for a sphere */                          \
    ARRAY(wrap_sense, wraps)           /* its side */                                                  \
    ARRAY(wrap_is_special, wraps)      /* what wrap_lanes.c is not for */                              \
    ARRAY(wrap_turning, wraps)         /* turning angle of the last move, if turns are counted */      \
    ARRAY(wrap_contact, CONTACT_NUMBERS *wraps)                                                        \
    ARRAY(pulley_contact, CONTACT_NUMBERS *pulleys)

/* How much squares and products of unit vectors in a blob may be off. */
#define UNIT_TOLERANCE PRECISE(1e-9, 1e-6)

/* Seven vectors and an angle: see core_trace. */
#define CONTACT_NUMBERS 22

#define STATE_MEMBER(name, length) real *name;
struct core {
    blob_view blob;
    int32_t is_counting; /* whether wraps remember their turns */
    int32_t has_laws;    /* whether any muscle is more than an ideal cable */
    int32_t has_friction;
    int32_t wrap_ends;   /* which directions any wrap is asked for */
    int32_t pushes;      /* points that core_push has given; the arrays are the caller's */
    const int32_t *push_frame;
    const real *push_point, *push_wrench;
    STATE_ARRAYS(STATE_MEMBER)
};
#undef STATE_MEMBER

/* 0, or a message in `message`: the blob is checked whole, so that nothing after it reads out of bounds. */
int blob_open(blob_view *view, const void *blob, size_t size, char *message, size_t capacity);

/* Write a message for people; always 1. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
int refuse(char *message, size_t capacity, const char *format, ...);

void tree_prepare(core *c);
void tree_move(core *c, const real *q);
void tree_direction(const core *c, int32_t frame, const real local[3], real world[3]);
/* link, at the last q; centre and moment; spin, velocity, slide and drift. */
void dynamics_links(core *c);
void dynamics_inertias(core *c);
void dynamics_velocities(core *c, const real *qd);
/* What the parent's acceleration is at the origin of frame i; that of the world is zero. */
void dynamics_carry(const core *c, int32_t i, const real *accelerations, real out[6]);
/* dqd = M^-1 impulse, with the articulated bodies of the last factorisation. */
void dynamics_factor(core *c, const real *armature);
void dynamics_respond(core *c, const real *impulse, real *change);
/* Change qd by impulses so that all velocities are within low and high; links and inertias are those of
   the last q. */
void limits_keep(core *c);
/* What a unit impulse on coordinate j does to qd, into `response`; after dynamics_factor. */
void limits_respond(core *c, int32_t j);
/* The impulses of the first `count` coordinates in `met` that bring each from `free` to its target; then
   qd with them. Their rows of `response` are known. */
void limits_solve(core *c, int32_t count);
void limits_apply(core *c, int32_t count);
/* As limits_keep, with the joints' Coulomb friction over a time h as well. */
void friction_keep(core *c, real h);
/* outer = extra, or nothing where that is NULL, and what core_push has given, at the last q. */
void pushes_add(core *c, const real *extra);
/* -L'f at the state: 0, or 1 + the index of the first command that is not finite. */
int muscles_pull(core *c, const real *u);
int muscles_are_sound(const core *c);
void paths_prepare(core *c);
void paths_move(core *c);
void tasks_move(core *c);

/* 0, or a message: points or the like in frames. */
int check_points(const char *what, const int32_t *frame, const real *position, int32_t points,
                 int32_t dofs, char *message, size_t capacity);

/* 0, or a message: surfaces, wraps and pulleys. */
int paths_check(const blob_view *view, char *message, size_t capacity);

/* 0, or a message; counts the laws' states and constants. */
int laws_check(blob_view *view, char *message, size_t capacity);
void laws_prepare(core *c);

static inline real dot3(const real a[3], const real b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross3(real out[3], const real a[3], const real b[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* out = R v */
static inline void rotate3(real out[3], const real R[9], const real v[3])
{
    for (int k = 0; k < 3; k++) out[k] = dot3(R + 3 * k, v);
}

/* out = A B */
static inline void multiply3(real out[9], const real A[9], const real B[9])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            out[3 * i + k] = A[3 * i] * B[k] + A[3 * i + 1] * B[3 + k] + A[3 * i + 2] * B[6 + k];
}

#include "points.h"

#endif
