/* Internal state of a core handle. */
#ifndef CARDSFLOW_STATE_H
#define CARDSFLOW_STATE_H

#include "../core.h"
#include "../named_arrays.h"
#include "../../generated/law_parameters.h"
#include "layout.h"

/* Lengths that STATE_ARRAYS uses. */
#define STATE_LENGTHS(view)                                                                            \
    const blob_counts *n = &(view)->counts;                                                            \
    const size_t law_states = (size_t)(view)->law_states, law_constants = (size_t)(view)->law_constants; \
    const size_t dofs = (size_t)n->dofs, muscles = (size_t)n->muscles;                                 \
    const size_t points = (size_t)n->points, tasks = (size_t)n->tasks;                                 \
    const size_t surfaces = (size_t)n->surfaces, wraps = (size_t)n->wraps;                             \
    const size_t pulleys = (size_t)n->pulleys, frames = (size_t)n->frames;                             \
    const size_t conditions = (size_t)n->conditions, moves = (size_t)n->moves;                         \
    const size_t closures = (size_t)n->closures, bends = (size_t)n->bends;                             \
    const size_t variables = (size_t)n->variables, terms = (size_t)n->terms;                           \
    const size_t wide = variables > dofs ? variables : 0; /* 0 if all variables are q */

/* ARRAY(name, number of reals): arrays in the working memory after the handle.
   A rotation about a constant axis is R0 + sin(q) R1 + (1 - cos(q)) R2, with R1 = R0 [a], R2 = R0 [a][a]. */
#define STATE_ARRAYS(ARRAY)                                                                            \
    ARRAY(rotation_sin, 9 * frames)                                                                    \
    ARRAY(rotation_cos, 9 * frames)                                                                    \
    ARRAY(rotation, 9 * frames) /* frame in the world, row by row */                                   \
    ARRAY(origin, 3 * frames)   /* of the frame in the world; lies on the axis */                      \
    ARRAY(axis, 3 * frames)     /* in the world */                                                     \
    ARRAY(point, 3 * points)  /* via points in the world */                                            \
    ARRAY(fixed_length, points) /* distance to the next point, if both are fixed to one frame; or -1 */ \
    ARRAY(link, 3 * frames)     /* from the parent frame's origin to this one's, in the world */       \
    ARRAY(spin, 3 * frames)     /* angular velocity of the frame, in the world */                      \
    ARRAY(slide, 3 * frames)    /* velocity of the motion itself: axis * qd */                         \
    ARRAY(velocity, 3 * frames) /* of the origin */                                                    \
    ARRAY(centre, 3 * frames)   /* first moment of mass about the origin, m r */                       \
    ARRAY(moment, 9 * frames)   /* second moment: inertia about the origin */                          \
    ARRAY(drift, 6 * frames)    /* acceleration relative to the parent, at qdd = 0 */                  \
    ARRAY(acceleration, 6 * frames)                                                                    \
    ARRAY(wrench, 6 * frames)   /* moment about the origin, force */                                   \
    ARRAY(articulated, 27 * frames)                                                                    \
    ARRAY(reaction, 6 * frames)                                                                        \
    ARRAY(pivot, frames)                                                                               \
    ARRAY(drive, frames)                                                                               \
    ARRAY(mass_matrix, dofs *dofs)                                                                     \
    ARRAY(coriolis, dofs)                                                                              \
    ARRAY(gravity, dofs)                                                                               \
    ARRAY(qdd, dofs)                                                                                   \
    ARRAY(at, variables)      /* variables of the last move: q and dependent ones */                   \
    ARRAY(moved, wide)        /* rates of all variables */                                             \
    ARRAY(bend, wide)         /* their second derivatives at qdd = 0 */                                \
    ARRAY(slope, terms)       /* f' and f'' at the last move */                                        \
    ARRAY(curve, terms)                                                                                \
    ARRAY(row, 3 * wide)      /* forces on all variables, or derivatives by them */                    \
    ARRAY(wide_matrix, wide *wide)                                                                     \
    ARRAY(dense, wide || bends ? dofs * dofs : 0) /* factors of M */                                   \
    ARRAY(q, dofs)            /* configuration of the robot */                                         \
    ARRAY(qd, dofs)                                                                                    \
    ARRAY(load, dofs)         /* generalised forces of a step */                                       \
    ARRAY(outer, dofs)        /* external generalised forces */                                        \
    ARRAY(work, 4)            /* of muscles, external forces, damping, cable friction */               \
    ARRAY(energies, 3)        /* kinetic, gravitational, of springs */                                 \
    ARRAY(momenta, 6)         /* linear, angular */                                                    \
    ARRAY(before, 2 * dofs + law_states) /* q, qd, law_states at the start of the step */              \
    ARRAY(stage_rates, 4 * (2 * dofs + law_states)) /* their rates at each Runge-Kutta stage */        \
    ARRAY(armature, variables)                                                                         \
    ARRAY(response, dofs *dofs) /* rows: change of qd for a unit impulse on a coordinate */            \
    ARRAY(factor, dofs *dofs)                                                                          \
    ARRAY(impulse, dofs)                                                                               \
    ARRAY(low, dofs)          /* velocity bounds due to the limits */                                  \
    ARRAY(high, dofs)                                                                                  \
    ARRAY(target, dofs)                                                                                \
    ARRAY(free, dofs)         /* velocities without limits */                                          \
    ARRAY(met, dofs)          /* indices of coordinates at a limit */                                  \
    ARRAY(grip, dofs)         /* maximum impulse of friction */                                        \
    ARRAY(unbraked, dofs)     /* velocities without limits and friction */                             \
    ARRAY(slides, dofs)       /* 0: held; -1: slips below 0; 1: slips above 0 */                       \
    ARRAY(sliding, dofs)      /* current solution for the velocities */                                \
    ARRAY(side, dofs)         /* -1 at the lower limit, 1 at the upper limit, 0 elsewhere */           \
    ARRAY(held, dofs)         /* the same for coordinates that rest at a limit, between events */      \
    ARRAY(hold_force, dofs)   /* forces of the limits on them, see core_derivative */                  \
    ARRAY(closure_gap, closures)                                                                       \
    ARRAY(closure_jacobian, closures *dofs)                                                            \
    ARRAY(closure_response, closures *dofs) /* rows: M^-1 J' */                                        \
    ARRAY(closure_factor, closures *closures)                                                          \
    ARRAY(closure_order, closures) /* indices of closures in the order of the pivots */                \
    ARRAY(closure_pivot, closures)                                                                     \
    ARRAY(closure_force, closures)                                                                     \
    ARRAY(closure_bias, closures)                                                                      \
    ARRAY(yielding, closures ? dofs : 0) /* compliance of a coordinate at a limit to a unit impulse */ \
    ARRAY(softness, n->limit_forces ? dofs : 0) /* compliance of a coordinate beyond a soft limit */   \
    ARRAY(closing, closures ? dofs : 0) /* change of q that closes the gaps */                         \
    ARRAY(closure_rows, closures *(dofs + 1))                                                          \
    ARRAY(free_motion, closures ? dofs * dofs : 0) /* N of qdd = N qdd_I + c, rows of coordinates */   \
    ARRAY(free_bias, closures ? dofs : 0)          /* c */                                             \
    ARRAY(free_row, closures ? dofs : 0)           /* row by all coordinates, before it is reduced by N */ \
    ARRAY(free_matrix, closures ? dofs * dofs : 0)                                                     \
    ARRAY(task_bias, 3 * tasks)                                                                        \
    ARRAY(lengths, muscles)                                                                            \
    ARRAY(branch_row, n->branches ? variables : 0) /* row of L of one branch */                        \
    ARRAY(jacobian, muscles *dofs)                                                                     \
    ARRAY(column_first, muscles) /* coordinates outside of this range do not change the length */     \
    ARRAY(column_end, muscles)                                                                         \
    ARRAY(torques, dofs)                                                                               \
    ARRAY(task_values, 3 * tasks)                                                                      \
    ARRAY(task_jacobian, 3 * tasks *dofs)                                                              \
    ARRAY(rates, muscles)                                                                              \
    ARRAY(tension_scale, muscles) /* see core.h */                                                     \
    ARRAY(tensions, muscles)                                                                           \
    ARRAY(law_states, law_states)                                                                      \
    ARRAY(law_rates, law_states)                                                                       \
    ARRAY(law_constants, law_constants) /* derived constants of the muscle laws */                     \
    ARRAY(far_tensions, bends ? muscles : 0) /* tensions at the last point, with friction */           \
    ARRAY(pull_jacobian, bends ? muscles *dofs : 0)                                                    \
    ARRAY(cable_stretches, bends ? muscles : 0) /* whether the cable stretches, see cable_stretch.c */ \
    ARRAY(cable_compliance, bends ? muscles : 0) /* in [m/N]; 0 if it is slack or does not stretch */  \
    ARRAY(cable_rise, bends ? muscles : 0)       /* mean tension over first tension, minus 1 */        \
    ARRAY(cable_beyond, bends ? muscles : 0)     /* elongation beyond that due to the first tension */ \
    ARRAY(bend_row, bends ? variables : 0)                                                             \
    ARRAY(bend_flow, bends *dofs) /* rows: A of cable_friction.c */                                    \
    ARRAY(bend_grip, bends)       /* mu theta */                                                       \
    ARRAY(bend_rates, bends)                                                                           \
    ARRAY(bend_presliding, bends)                                                                      \
    ARRAY(bend_behind, bends)     /* length of the path from the bend to the far end */                \
    ARRAY(bend_share, bends)      /* share of the stretch of the cable after the bend */               \
    ARRAY(bend_owed, bends)       /* sliding distance still due to earlier stretch */                  \
    ARRAY(bend_lag, bends)        /* sliding distance absorbed by stretch due to friction */           \
    ARRAY(bend_soft, bends)       /* compliance of the cable before a bend */                          \
    ARRAY(bend_tension, bends)    /* on the driven side */                                             \
    ARRAY(bend_way, bends)        /* of a step, over the presliding distance; and solution */          \
    ARRAY(bend_next, bends)       /* result of an iteration */                                         \
    ARRAY(bend_pull, bends)                                                                            \
    ARRAY(bend_next_pull, bends)                                                                       \
    ARRAY(bend_side, bends)                                                                            \
    ARRAY(bend_force, bends)                                                                           \
    ARRAY(bend_slope, bends)                                                                           \
    ARRAY(bend_resistance, bends) /* added to M */                                                     \
    ARRAY(torques_before, bends ? dofs : 0) /* without cable friction */                               \
    ARRAY(force_low, muscles)                                                                          \
    ARRAY(force_high, muscles)                                                                         \
    ARRAY(commands, muscles)                                                                           \
    ARRAY(reached, REACH_NUMBERS *muscles) /* see core_reach */                                        \
    ARRAY(surface_place, 6 * surfaces) /* centre and axis in the world */                              \
    ARRAY(surface_across, 3 * surfaces) /* of an ellipsoid: its x axis in the world */                 \
    ARRAY(wrap_is_special, wraps)      /* 0: wrap_simd.c computes it in a lane; lanes have this order */ \
    ARRAY(wrap_is_inside, wraps)       /* 1: the cable runs inside */                                  \
    ARRAY(lane_wrap, wraps)                                                                            \
    ARRAY(lane_radius, wraps ? wraps + LANE_PADDING : 0)                                               \
    ARRAY(lane_half, wraps ? wraps + LANE_PADDING : 0) /* infinite for an infinite cylinder */         \
    ARRAY(lane_has_axis, wraps ? wraps + LANE_PADDING : 0) /* 1 for a cylinder, 0 for a sphere */      \
    ARRAY(lane_sense, wraps ? wraps + LANE_PADDING : 0) /* side of the wrap */                         \
    ARRAY(lane_is_mujoco, wraps ? wraps + LANE_PADDING : 0) /* 1 for MuJoCo's rule */                  \
    ARRAY(lane_is_guided, wraps ? wraps + LANE_PADDING : 0) /* 1 for MuJoCo's rule with a side point */ \
    ARRAY(lane_aside, 3 * wraps)       /* from the centre to this point, in the frame of the surface */ \
    ARRAY(wrap_before, wraps)          /* via point before it, of a routed muscle; -1: inactive */     \
    ARRAY(wrap_rank, wraps)            /* rank among wraps between the same points */                  \
    ARRAY(wrap_turn, wraps)            /* sense of turning there */                                    \
    ARRAY(point_share, points)         /* activity of a via point in its path, 0 to 1 */               \
    ARRAY(condition_slope, conditions) /* derivative of that by its coordinate */                      \
    ARRAY(move_slope, moves)           /* of the function that moves a point */                        \
    ARRAY(is_routed, muscles)          /* 1: routed.c computes it */                                   \
    ARRAY(stored_path, PATH_NUMBERS *wraps) /* of an ellipsoid: last path of a wrap, see ellipsoid.c */ \
    ARRAY(wrap_contact, CONTACT_NUMBERS *wraps)                                                        \
    ARRAY(pulley_contact, CONTACT_NUMBERS *pulleys)

/* Values of a muscle, see laws.c. */
#define REACH_NUMBERS (6 + MAX_LAW_STATES)

/* Maximum number of lanes after the last wrap that complete a vector. */
#define LANE_PADDING 3

/* See ellipsoid.c. */
#define PATH_NUMBERS 20

/* Seven vectors and an angle: see core_trace. */
#define CONTACT_NUMBERS 22

struct core {
    blob_view blob;
    int32_t moving;      /* 1 + the coordinate along which q has a tangent, the only one; 0 otherwise */
    int32_t is_straight; /* whether all paths are straight, see straight.h */
    int32_t has_laws;    /* whether any muscle is not an ideal cable */
    int32_t has_weight;  /* whether any muscle is a heavy cable */
    int32_t has_fibres;  /* whether any muscle has an elastic tendon and thus a fibre as a state */
    int32_t is_settling; /* true in a step that settles fibres, whose rates are then not computed */
    int32_t has_friction;
    int32_t has_soft_limits;
    int32_t is_rubbing;  /* true while velocities of a step with cable friction are computed */
    int32_t friction_rounds, friction_settled;
    int32_t is_factored; /* whether articulated bodies of the last q have the armature of the blob */
    int32_t is_driven;   /* whether variables other than q exist */
    int32_t closure_rank; /* number of active closures, first ones in closure_order */
    int32_t lanes;       /* number of wraps that are computed in parallel */
    int32_t wrap_ends;   /* directions needed of any of them */
    int32_t has_rules;   /* whether any of them has MuJoCo's rule */
    int32_t vector_size; /* numbers in a vector of the processor: 8 (AVX-512), 4 (AVX2), or 0 if not known */
    int32_t *leaving;    /* bits of lanes that leave a group, see `agreed`; NULL without lanes */
    int32_t externals;   /* points of core_external_wrenches; the caller owns the arrays */
    const int32_t *external_frame;
    const real *external_point, *external_wrench;
    STATE_ARRAYS(NAMED_MEMBER)
};

/* Return the number of reals in the working memory after a handle. */
static inline size_t state_reals(const blob_view *view)
{
    size_t count = 0;
    STATE_LENGTHS(view)
    STATE_ARRAYS(NAMED_LENGTH)
    return count;
}

/* Return the number of reals in the blob. */
static inline size_t blob_reals(const blob_view *view)
{
    size_t length = 0;
#define ADD_int32_t(count)
#define ADD_real(count) length += (size_t)(count);
#define ADD_FIELD(type, name, per_item, count) ADD_##type(per_item * view->counts.count)
    BLOB_FIELDS(ADD_FIELD)
#undef ADD_FIELD
#undef ADD_int32_t
#undef ADD_real
    return length;
}

/* Return the number of q, qd and law_states. */
static inline size_t state_size(const core *c)
{
    return 2 * (size_t)c->blob.counts.dofs + (size_t)c->blob.law_states;
}

/* Decisions of instances that are computed in lanes. A lane that leaves its group computes numbers without
   meaning from then on; its step is repeated alone, see ../batch/lanes.c. */
#if defined(CARDSFLOW_LANES)
/* Return whether a condition holds in the first lane; lanes that differ leave. */
static inline int agreed(const core *c, truth x)
{
    const int bits = bits_of(x), is_first = bits & 1, others = is_first ? ~bits & ((1 << GROUP) - 1) : bits;
    if (others) *c->leaving |= others;
    return is_first;
}

/* Return 0; lanes in which the condition holds leave. */
static inline int is_rare(const core *c, truth x)
{
    const int bits = bits_of(x);
    if (bits) *c->leaving |= bits;
    return 0;
}
#else
/* Return whether a condition holds. */
static inline int agreed(const core *c, int x)
{
    (void)c;
    return x;
}

/* The same for a condition that rarely holds. */
static inline int is_rare(const core *c, int x)
{
    (void)c;
    return x;
}
#endif

#endif
