/* Forward dynamics by articulated bodies (Featherstone). The inertia of an articulated body is stored as
   three 3x3 blocks: moment = I alpha + H a, force = H' alpha + M a. */
#include "forward.h"

#include "../kinematics/bodies.h"
#include "dense.h"
#include "spatial.h"

#include <string.h>

typedef struct {
    real I[9], H[9], M[9];
} articulated;

static articulated *body(core *c, int32_t i)
{
    return (articulated *)(void *)(c->articulated + 27 * i);
}

static inline void begin_body(core *c, int32_t i)
{
    articulated *A = body(c, i);
    const real *h = c->centre + 3 * i, m = c->blob.mass[i];
    const real skew[9] = {number(0), -h[2], h[1], h[2], number(0), -h[0], -h[1], h[0], number(0)};
    memcpy(A->I, c->moment + 9 * i, sizeof A->I);
    memcpy(A->H, skew, sizeof A->H);
    memset(A->M, 0, sizeof A->M);
    A->M[0] = A->M[4] = A->M[8] = m;
}

/* Compute the velocity-dependent wrench: w x I w, w x (w x c). */
static inline void begin_wrench(core *c, int32_t i)
{
    real *wrench = c->wrench + 6 * i, Iw[3];
    const real *w = c->spin + 3 * i;
    memset(wrench, 0, 6 * sizeof(real));
    rotate3(Iw, c->moment + 9 * i, w);
    add_cross3(wrench, w, Iw);
    add_centripetal(wrench + 3, w, c->centre + 3 * i);
}

static inline void transposed3(real out[3], const real R[9], const real v[3])
{
    for (int k = 0; k < 3; k++) out[k] = R[k] * v[0] + R[3 + k] * v[1] + R[6 + k] * v[2];
}

/* Compute wrench = A motion. */
static inline void apply(const articulated *A, const real motion[6], real *restrict wrench)
{
    real other[3];
    rotate3(wrench, A->I, motion);
    rotate3(other, A->H, motion + 3);
    add3(wrench, other);
    transposed3(wrench + 3, A->H, motion);
    rotate3(other, A->M, motion + 3);
    add3(wrench + 3, other);
}

/* Compute U = A S. */
static inline void react(const core *c, int32_t i, const articulated *A, real *restrict U)
{
    const real *axis = c->axis + 3 * i;
    if (c->blob.motion[i] == ROTATION) {
        rotate3(U, A->I, axis);
        transposed3(U + 3, A->H, axis);
    } else {
        rotate3(U, A->H, axis);
        rotate3(U + 3, A->M, axis);
    }
}

/* Compute A - U U'/d: the inertia when the joint is free. */
static inline void release(articulated *restrict A, const real *restrict U, real d)
{
    const real share = 1 / d; /* avoids slow divisions */
    for (int a = 0; a < 3; a++) {
        const real n = U[a] * share, f = U[3 + a] * share;
        for (int b = 0; b < 3; b++) {
            A->I[3 * a + b] -= n * U[b];
            A->H[3 * a + b] -= n * U[3 + b];
            A->M[3 * a + b] -= f * U[3 + b];
        }
    }
}

/* Compute out = [r] K, the cross product of r and each column. */
static inline void skewed(real *restrict out, const real r[3], const real *restrict K)
{
    for (int b = 0; b < 3; b++) {
        out[b] = r[1] * K[6 + b] - r[2] * K[3 + b];
        out[3 + b] = r[2] * K[b] - r[0] * K[6 + b];
        out[6 + b] = r[0] * K[3 + b] - r[1] * K[b];
    }
}

/* Add A about the origin of a frame to P about the origin of its parent:
     M + M,   H + [r] M,   I + [r] H' + ([r] H')' + [r] M [r]' */
static inline void add_articulated(const core *c, articulated *restrict P, const articulated *restrict A,
                                   const real *restrict r)
{
    real rM[9], rH[9], Ht[9], rMt[9], rMr[9];
    if (agreed(c, (r[0] == 0) & (r[1] == 0) & (r[2] == 0))) { /* the motions of one joint share their origin */
        for (int k = 0; k < 9; k++) P->I[k] += A->I[k], P->H[k] += A->H[k], P->M[k] += A->M[k];
        return;
    }
    skewed(rM, r, A->M);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) Ht[3 * a + b] = A->H[3 * b + a], rMt[3 * a + b] = rM[3 * b + a];
    skewed(rH, r, Ht);
    skewed(rMr, r, rMt);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            const int k = 3 * a + b, t = 3 * b + a;
            P->M[k] += A->M[k];
            P->H[k] += A->H[k] + rM[k];
            P->I[k] += A->I[k] + rH[k] + rH[t] + rMr[k];
        }
}

/* Compute U, the inertia along the motion of the joint, and A when the joint is free. */
static inline void free_joint(core *c, int32_t i, const real *armature)
{
    articulated *A = body(c, i);
    real *U = c->reaction + 6 * i;
    react(c, i, A, U);
    c->pivot[i] = generalised_force(c, i, U) + armature[c->blob.coordinate[i]];
    if (c->blob.parent[i] >= 0) release(A, U, c->pivot[i]);
}

static void backward(core *c, const real *tau, const real *armature)
{
    for (int32_t i = c->blob.counts.dofs - 1; i >= 0; i--) {
        const int32_t parent = c->blob.parent[i];
        const real *U = c->reaction + 6 * i;
        real *wrench = c->wrench + 6 * i, more[6];
        free_joint(c, i, armature);
        const real u = c->drive[i] = tau[c->blob.coordinate[i]] - generalised_force(c, i, wrench);
        if (parent < 0) continue;
        apply(body(c, i), c->drift + 6 * i, more);
        for (int k = 0; k < 6; k++) wrench[k] += more[k] + U[k] * (u / c->pivot[i]);
        add_to_parent(c, i, wrench, c->wrench + 6 * parent);
        add_articulated(c, body(c, parent), body(c, i), c->link + 3 * i);
    }
}

static int is_dense(const core *c)
{
    return c->is_driven || c->is_rubbing;
}

void dynamics_factor(core *c, const real *armature)
{
    if (is_dense(c)) {
        dense_factor(c, armature);
        return;
    }
    if (c->is_factored) return;
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) begin_body(c, i);
    for (int32_t i = c->blob.counts.dofs - 1; i >= 0; i--) {
        const int32_t parent = c->blob.parent[i];
        free_joint(c, i, armature);
        if (parent >= 0) add_articulated(c, body(c, parent), body(c, i), c->link + 3 * i);
    }
}

void dynamics_respond(core *c, const real *impulse, real *change)
{
    if (is_dense(c)) {
        memcpy(change, impulse, (size_t)c->blob.counts.dofs * sizeof(real));
        dense_solve(c, change);
        return;
    }
    memset(c->wrench, 0, 6 * (size_t)c->blob.counts.dofs * sizeof(real));
    for (int32_t i = c->blob.counts.dofs - 1; i >= 0; i--) {
        real *wrench = c->wrench + 6 * i;
        const real *U = c->reaction + 6 * i;
        c->drive[i] = impulse[c->blob.coordinate[i]] - generalised_force(c, i, wrench);
        if (c->blob.parent[i] < 0 || (all_of(c->drive[i] == 0) && is_zero_wrench(wrench))) continue;
        for (int k = 0; k < 6; k++) wrench[k] += U[k] * (c->drive[i] / c->pivot[i]);
        add_to_parent(c, i, wrench, c->wrench + 6 * c->blob.parent[i]);
    }
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        real *jump = c->acceleration + 6 * i;
        const real *U = c->reaction + 6 * i;
        bodies_parent_acceleration(c, i, c->acceleration, jump);
        const real transmitted = dot3(U, jump) + dot3(U + 3, jump + 3);
        const real qdd = change[c->blob.coordinate[i]] = (c->drive[i] - transmitted) / c->pivot[i];
        real *moved = jump + (c->blob.motion[i] == ROTATION ? 0 : 3);
        for (int k = 0; k < 3; k++) moved[k] += qdd * c->axis[3 * i + k];
    }
}

/* Compute qdd from the world to the leaves. Gravity is an upward acceleration of the world. */
static void forward(core *c)
{
    const real *g = c->blob.gravity;
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        real *acceleration = c->acceleration + 6 * i;
        const real *U = c->reaction + 6 * i, *drift = c->drift + 6 * i;
        bodies_parent_acceleration(c, i, c->acceleration, acceleration);
        if (c->blob.parent[i] < 0)
            for (int k = 0; k < 3; k++) acceleration[3 + k] = -g[k];
        for (int k = 0; k < 6; k++) acceleration[k] += drift[k];
        const real transmitted = dot3(U, acceleration) + dot3(U + 3, acceleration + 3);
        const real qdd = c->qdd[c->blob.coordinate[i]] = (c->drive[i] - transmitted) / c->pivot[i];
        real *moved = acceleration + (c->blob.motion[i] == ROTATION ? 0 : 3);
        for (int k = 0; k < 3; k++) moved[k] += qdd * c->axis[3 * i + k];
    }
}

void dynamics_accelerate(core *c, const real *qd, const real *tau, const real *armature)
{
    if (is_dense(c)) {
        dense_accelerate(c, qd, tau, armature);
        return;
    }
    bodies_links(c);
    bodies_inertias(c);
    bodies_velocities(c, qd);
    c->is_factored = 1;
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        begin_body(c, i);
        begin_wrench(c, i);
        if (any_of(armature[i] != c->blob.armature[i])) c->is_factored = 0;
    }
    backward(c, tau, armature);
    forward(c);
}
