/* Derivatives of kinematics and inverse dynamics along a direction, see motion.c and inverse.c. */
#include "tangent_frames.h"

#include <string.h>

/* out += d(a x b) */
static void add_cross_change(real out[3], const real a[3], const real da[3], const real b[3],
                             const real db[3])
{
    add_cross3(out, da, b);
    add_cross3(out, a, db);
}

/* out += d(w x (w x r)) */
static void add_centripetal_change(real out[3], const real w[3], const real dw[3], const real r[3],
                                   const real dr[3])
{
    real wr[3], change[3] = {0, 0, 0};
    cross3(wr, w, r);
    add_cross_change(change, w, dw, r, dr);
    add_cross_change(out, w, dw, wr, change);
}

void tangent_displace(const core *c, frame *frames, const real *dq)
{
    static const frame world;
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        frame *f = frames + i;
        const frame *parent = c->blob.parent[i] < 0 ? &world : frames + c->blob.parent[i];
        const real change = dq[c->blob.coordinate[i]], *axis = c->axis + 3 * i;
        memcpy(f->turn, parent->turn, sizeof f->turn);
        memcpy(f->shift, parent->shift, sizeof f->shift);
        cross3(f->link, parent->turn, c->link + 3 * i);
        cross3(f->axis, parent->turn, axis);
        for (int k = 0; k < 3; k++)
            (c->blob.motion[i] == ROTATION ? f->turn : f->link)[k] += change * axis[k];
        add3(f->shift, f->link);
    }
}

void tangent_point(const core *c, const frame *frames, int32_t i, const real point[3], real out[3])
{
    memset(out, 0, 3 * sizeof(real));
    if (i < 0) return;
    const real *origin = c->origin + 3 * i;
    const real arm[3] = {point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]};
    memcpy(out, frames[i].shift, 3 * sizeof(real));
    add_cross3(out, frames[i].turn, arm);
}

void tangent_apply(const core *c, frame *frames, int32_t i, const real point[3], const real force[3],
                   const real force_change[3])
{
    if (i < 0) return;
    frame *f = frames + i;
    real arm[3], arm_change[3], moment[3], change[3] = {0, 0, 0};
    tangent_point(c, frames, i, point, arm_change);
    for (int k = 0; k < 3; k++) arm[k] = point[k] - c->origin[3 * i + k], arm_change[k] -= f->shift[k];
    cross3(moment, arm, force);
    add_cross_change(change, arm, arm_change, force, force_change);
    for (int k = 0; k < 3; k++) {
        f->wrench[k] -= moment[k], f->wrench[3 + k] -= force[k];
        f->wrench_change[k] -= change[k], f->wrench_change[3 + k] -= force_change[k];
    }
}

/* Spin and acceleration of a frame, and their changes; see motion.c and inverse.c. */
static void move_frame(const core *c, frame *f, const frame *parent, int32_t i, real rate,
                       real rate_change, real qdd)
{
    const int turns = c->blob.motion[i] == ROTATION, at = turns ? 0 : 3;
    const real *axis = c->axis + 3 * i, *r = c->link + 3 * i;
    real own[3], own_change[3];
    for (int k = 0; k < 3; k++) {
        own[k] = rate * axis[k];
        own_change[k] = rate * f->axis[k] + rate_change * axis[k];
        f->spin[k] = parent->spin[k] + (turns ? own[k] : 0);
        f->spin_change[k] = parent->spin_change[k] + (turns ? own_change[k] : 0);
    }
    memcpy(f->motion, parent->motion, sizeof f->motion);
    memcpy(f->motion_change, parent->motion_change, sizeof f->motion_change);
    add_cross3(f->motion + 3, parent->motion, r);
    add_cross_change(f->motion_change + 3, parent->motion, parent->motion_change, r, f->link);
    add_centripetal(f->motion + 3, parent->spin, r);
    add_centripetal_change(f->motion_change + 3, parent->spin, parent->spin_change, r, f->link);
    for (int times = turns ? 1 : 2; times > 0; times--) { /* Coriolis: twice */
        add_cross3(f->motion + at, parent->spin, own);
        add_cross_change(f->motion_change + at, parent->spin, parent->spin_change, own, own_change);
    }
    for (int k = 0; k < 3; k++) {
        f->motion[at + k] += qdd * axis[k];
        f->motion_change[at + k] += qdd * f->axis[k];
    }
}

/* d(I v) = turn x I v - I (turn x v) + I dv, I being carried along */
static void add_inertia_change(real out[3], const real I[9], const real turn[3], const real v[3],
                               const real dv[3])
{
    real Iv[3], turned[3], left[3], I_left[3];
    rotate3(Iv, I, v);
    cross3(turned, turn, v);
    for (int k = 0; k < 3; k++) left[k] = dv[k] - turned[k];
    rotate3(I_left, I, left);
    add_cross3(out, turn, Iv);
    add3(out, I_left);
}

/* f = m a + alpha x c + w x (w x c),   n = I alpha + c x a + w x I w */
static void load_frame(const core *c, frame *f, int32_t i)
{
    const real *centre = c->centre + 3 * i, *I = c->moment + 9 * i, m = c->blob.mass[i];
    const real *alpha = f->motion, *a = f->motion + 3, *dalpha = f->motion_change, *da = dalpha + 3;
    real centre_change[3], Iw[3], Iw_change[3] = {0, 0, 0}, Ia[3];
    cross3(centre_change, f->turn, centre);
    for (int k = 0; k < 3; k++) f->wrench[3 + k] += m * a[k], f->wrench_change[3 + k] += m * da[k];
    add_cross3(f->wrench + 3, alpha, centre);
    add_cross_change(f->wrench_change + 3, alpha, dalpha, centre, centre_change);
    add_centripetal(f->wrench + 3, f->spin, centre);
    add_centripetal_change(f->wrench_change + 3, f->spin, f->spin_change, centre, centre_change);
    rotate3(Ia, I, alpha);
    add3(f->wrench, Ia);
    add_inertia_change(f->wrench_change, I, f->turn, alpha, dalpha);
    add_cross3(f->wrench, centre, a);
    add_cross_change(f->wrench_change, centre, centre_change, a, da);
    rotate3(Iw, I, f->spin);
    add_inertia_change(Iw_change, I, f->turn, f->spin, f->spin_change);
    add_cross3(f->wrench, f->spin, Iw);
    add_cross_change(f->wrench_change, f->spin, f->spin_change, Iw, Iw_change);
}

static void collect_changes(const core *c, frame *frames, real *out)
{
    for (int32_t i = c->blob.counts.dofs - 1; i >= 0; i--) {
        const frame *f = frames + i;
        const int at = c->blob.motion[i] == ROTATION ? 0 : 3;
        const real *axis = c->axis + 3 * i, *r = c->link + 3 * i;
        out[c->blob.coordinate[i]] = dot3(f->axis, f->wrench + at) + dot3(axis, f->wrench_change + at);
        if (c->blob.parent[i] < 0) continue;
        frame *parent = frames + c->blob.parent[i];
        for (int k = 0; k < 6; k++)
            parent->wrench[k] += f->wrench[k], parent->wrench_change[k] += f->wrench_change[k];
        add_cross3(parent->wrench, r, f->wrench + 3);
        add_cross_change(parent->wrench_change, r, f->link, f->wrench + 3, f->wrench_change + 3);
    }
}

void tangent_ask(const core *c, frame *frames, const real up[3], const real *qd, const real *dqd,
                const real *qdd, real *out)
{
    frame world;
    memset(&world, 0, sizeof world);
    memcpy(world.motion + 3, up, 3 * sizeof(real));
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        const int32_t j = c->blob.coordinate[i];
        const frame *parent = c->blob.parent[i] < 0 ? &world : frames + c->blob.parent[i];
        move_frame(c, frames + i, parent, i, qd[j], dqd[j], qdd[j]);
        load_frame(c, frames + i, i);
    }
    collect_changes(c, frames, out);
}

void tangent_forget(const core *c, frame *frames)
{
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        memset(frames[i].wrench, 0, sizeof frames[i].wrench);
        memset(frames[i].wrench_change, 0, sizeof frames[i].wrench_change);
    }
}
