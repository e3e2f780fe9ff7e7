/* The closures of loop joints, scalar equations between two frames A and B:

     CLOSURE_POINT      u.(p_B - p_A) = 0,   u and p_A fixed to A, p_B to B
     CLOSURE_DIRECTION  u.v = 0,             u fixed to A, v to B

   The derivative is a velocity of B relative to A: of the point of B relative to the coincident point of A,
   along u; or the angular velocity along v x u. */
#include "closures.h"

#include "../kinematics/bodies.h"
#include "../kinematics/joint_variables.h"
#include "../kinematics/points.h"
#include "../kinematics/tree.h"
#include "../math/elementary.h"

#include <string.h>

/* A closure in the world. */
typedef struct {
    int32_t A, B;
    real u[3], at[3], other[3]; /* of a direction: `at` is the target of v, `other` is v */
} placed_closure;

static placed_closure closure_at(const core *c, int32_t k)
{
    const blob_view *b = &c->blob;
    placed_closure closure = {b->closure_frame[2 * k], b->closure_frame[2 * k + 1], {0}, {0}, {0}};
    const int is_point = b->closure_kind[k] == CLOSURE_POINT;
    tree_direction(c, closure.A, b->closure_along + 3 * k, closure.u);
    (is_point ? tree_point : tree_direction)(c, closure.A, b->closure_at + 3 * k, closure.at);
    (is_point ? tree_point : tree_direction)(c, closure.B, b->closure_other + 3 * k, closure.other);
    return closure;
}

/* Add the derivatives by all variables of the motion of B relative to A: along a force through a point, and
   about a moment. */
static void add_rates(const core *c, const placed_closure *closure, const real force[3], const real moment[3],
                      real *row)
{
    int32_t A = closure->A, B = closure->B;
    while (A != B) { /* parents come first: common ancestors are skipped */
        const int32_t j = B > A ? B : A;
        const real *axis = c->axis + 3 * j, *origin = c->origin + 3 * j;
        real about[3] = {moment[0], moment[1], moment[2]};
        real arm[3] = {closure->other[0] - origin[0], closure->other[1] - origin[1], closure->other[2] - origin[2]};
        add_cross3(about, arm, force);
        const real rate = dot3(axis, c->blob.motion[j] == ROTATION ? about : force);
        row[c->blob.coordinate[j]] += j == B ? rate : -rate;
        if (j == B) B = c->blob.parent[j];
        else A = c->blob.parent[j];
    }
}

static const real NONE[3] = {0, 0, 0};

/* Return the gap of a direction: u.v; or the angle between v and its target, in the plane of the target and
   u, which does not vanish if v points in the opposite direction. `moment` is the axis of the derivative. */
static real direction_gap(const placed_closure *closure, int as_angle, real moment[3])
{
    const real s = dot3(closure->u, closure->other), c = dot3(closure->at, closure->other), square = s * s + c * c;
    cross3(moment, closure->other, closure->u);
    if (!as_angle || value_of(square) < 1e-12) return s;
    real across[3];
    cross3(across, closure->other, closure->at);
    for (int k = 0; k < 3; k++) moment[k] = (c * moment[k] - s * across[k]) / square;
    return arc_tangent(s, c);
}

static int is_aligned(const core *c, int32_t k)
{
    const real *along = c->blob.closure_at + 3 * k;
    return along[0] != 0 || along[1] != 0 || along[2] != 0;
}

static void move(core *c, int as_angles)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    const size_t width = c->is_driven ? (size_t)c->blob.counts.variables : dofs;
    for (int32_t k = 0; k < c->blob.counts.closures; k++) {
        const placed_closure closure = closure_at(c, k);
        real *row = c->closure_jacobian + (size_t)k * dofs, *wide = c->is_driven ? c->row : row, moment[3];
        memset(wide, 0, width * sizeof(real));
        if (c->blob.closure_kind[k] == CLOSURE_POINT) {
            c->closure_gap[k] = dot3(closure.u, closure.other) - dot3(closure.u, closure.at);
            add_rates(c, &closure, closure.u, NONE, wide);
        } else {
            c->closure_gap[k] = direction_gap(&closure, as_angles && is_aligned(c, k), moment);
            add_rates(c, &closure, NONE, moment, wide);
        }
        if (c->is_driven) variables_fold(c, wide, row);
    }
}

void closures_move(core *c)
{
    move(c, 0);
}

void closures_angles(core *c)
{
    move(c, 1);
}

/* Compute the acceleration of a point of a frame at qdd = 0, and its velocity. */
static void point_motion(const core *c, int32_t frame, const real point[3], real velocity[3], real acceleration[3])
{
    memset(velocity, 0, 3 * sizeof(real));
    memset(acceleration, 0, 3 * sizeof(real));
    if (frame < 0) return;
    const real *origin = c->origin + 3 * frame, *spin = c->spin + 3 * frame, *spatial = c->acceleration + 6 * frame;
    const real arm[3] = {point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]};
    memcpy(velocity, c->velocity + 3 * frame, 3 * sizeof(real));
    add_cross3(velocity, spin, arm);
    memcpy(acceleration, spatial + 3, 3 * sizeof(real));
    add_cross3(acceleration, spatial, arm);
    add_centripetal(acceleration, spin, arm);
}

/* Return u.(a_B - a_A - 2 w_A x (v_B - v_A)), all at the point of B. */
static real point_bias(const core *c, const placed_closure *closure)
{
    real vA[3], vB[3], aA[3], aB[3], coriolis[3];
    point_motion(c, closure->A, closure->other, vA, aA);
    point_motion(c, closure->B, closure->other, vB, aB);
    for (int k = 0; k < 3; k++) vB[k] -= vA[k];
    cross3(coriolis, closure->A < 0 ? NONE : c->spin + 3 * closure->A, vB);
    return dot3(closure->u, aB) - dot3(closure->u, aA) - 2 * dot3(closure->u, coriolis);
}

/* Return (alpha_B - alpha_A).(v x u) + (w_B - w_A).((w_B x v) x u + v x (w_A x u)). */
static real direction_bias(const core *c, const placed_closure *closure)
{
    const real *wA = closure->A < 0 ? NONE : c->spin + 3 * closure->A;
    const real *wB = closure->B < 0 ? NONE : c->spin + 3 * closure->B;
    const real *aA = closure->A < 0 ? NONE : c->acceleration + 6 * closure->A;
    const real *aB = closure->B < 0 ? NONE : c->acceleration + 6 * closure->B;
    real across[3], v_rate[3], u_rate[3], change[3] = {0, 0, 0};
    cross3(across, closure->other, closure->u);
    cross3(v_rate, wB, closure->other);
    cross3(u_rate, wA, closure->u);
    add_cross3(change, v_rate, closure->u);
    add_cross3(change, closure->other, u_rate);
    return dot3(aB, across) - dot3(aA, across) + dot3(wB, change) - dot3(wA, change);
}

void closures_bias(core *c)
{
    for (int32_t i = 0; i < c->blob.counts.frames; i++) {
        real *acceleration = c->acceleration + 6 * i;
        bodies_parent_acceleration(c, i, c->acceleration, acceleration);
        for (int k = 0; k < 6; k++) acceleration[k] += c->drift[6 * i + k];
    }
    for (int32_t k = 0; k < c->blob.counts.closures; k++) {
        const placed_closure closure = closure_at(c, k);
        const int is_point = c->blob.closure_kind[k] == CLOSURE_POINT;
        c->closure_bias[k] = is_point ? point_bias(c, &closure) : direction_bias(c, &closure);
    }
}

int32_t closures_worst(const core *c)
{
    int32_t worst = 0;
    for (int32_t k = 1; k < c->blob.counts.closures; k++)
        if (value_of(fabs(c->closure_gap[k])) > value_of(fabs(c->closure_gap[worst]))) worst = k;
    return worst;
}

void core_closures(core *c, const real *qd)
{
    closures_move(c);
    bodies_links(c);
    bodies_velocities(c, qd);
    closures_bias(c);
}
