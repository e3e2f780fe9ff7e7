/* Derivatives of a step along a direction.

   All vectors are in the world. A frame that turns by a small angle d and whose origin moves by s takes
   everything that it carries along: a vector v of it changes by d x v. Differentiated so, the passes of
   inverse dynamics give the change of the forces that a motion asks for, at constant accelerations. The
   accelerations then change by what makes up for that:

     (M + h D + h^2 K) dqdd = -d(C + G + M qdd - J'F) - D dqd - K (dq + h dqd)

   with F the forces of cables and loads on the points where they act.                                   */
#include "tangent.h"

#include "spatial.h"

#include <math.h>
#include <string.h>

/* Of every frame: how it turned, how its origin moved; changes of link and axis; spin, acceleration and
   wrench, each with its change.                                                                         */
typedef struct {
    double turn[3], shift[3], link[3], axis[3];
    double spin[3], spin_change[3];
    double motion[6], motion_change[6];
    double wrench[6], wrench_change[6];
} frame;

typedef struct {
    frame *frames;                        /* dofs */
    double *begin_q, *begin_qd, *free;    /* dofs each */
    double *qdd, *asked, *change, *still; /* dofs each */
    double *response, *factor;            /* dofs x dofs */
} work;

size_t core_tangent_size(const core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    if (c->has_laws || c->blob.counts.wraps || c->blob.counts.pulleys) return 0;
    return dofs * (sizeof(frame) / sizeof(double) + 7) + 2 * dofs * dofs;
}

static work placed(const core *c, double *memory)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    work k = {.frames = (frame *)(void *)memory};
    double **const vectors[] = {&k.begin_q, &k.begin_qd, &k.free, &k.qdd, &k.asked, &k.change, &k.still};
    double *at = memory + dofs * (sizeof(frame) / sizeof(double));
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++, at += dofs) *vectors[i] = at;
    memset(k.still, 0, dofs * sizeof(double));
    k.response = at;
    k.factor = at + dofs * dofs;
    return k;
}

/* out += d(a x b) */
static void add_cross_change(double out[3], const double a[3], const double da[3], const double b[3],
                             const double db[3])
{
    add_cross3(out, da, b);
    add_cross3(out, a, db);
}

/* out += d(w x (w x r)) */
static void add_centripetal_change(double out[3], const double w[3], const double dw[3], const double r[3],
                                   const double dr[3])
{
    double wr[3], change[3] = {0, 0, 0};
    cross3(wr, w, r);
    add_cross_change(change, w, dw, r, dr);
    add_cross_change(out, w, dw, wr, change);
}

/* ----------------------------------------------------------------------------- frames and points */

static void displace(const core *c, frame *frames, const double *dq)
{
    static const frame world;
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        frame *f = frames + i;
        const frame *parent = c->blob.parent[i] < 0 ? &world : frames + c->blob.parent[i];
        const double change = dq[c->blob.coordinate[i]], *axis = c->axis + 3 * i;
        memcpy(f->turn, parent->turn, sizeof f->turn);
        memcpy(f->shift, parent->shift, sizeof f->shift);
        cross3(f->link, parent->turn, c->link + 3 * i);
        cross3(f->axis, parent->turn, axis);
        for (int k = 0; k < 3; k++)
            (c->blob.motion[i] == ROTATION ? f->turn : f->link)[k] += change * axis[k];
        add3(f->shift, f->link);
    }
}

/* How a point that a frame carries moves. */
static void point_change(const core *c, const frame *frames, int32_t i, const double point[3],
                         double out[3])
{
    memset(out, 0, 3 * sizeof(double));
    if (i < 0) return;
    const double *origin = c->origin + 3 * i;
    const double arm[3] = {point[0] - origin[0], point[1] - origin[1], point[2] - origin[2]};
    memcpy(out, frames[i].shift, 3 * sizeof(double));
    add_cross3(out, frames[i].turn, arm);
}

/* A force on a point of a frame: off the wrench that the frame asks for. */
static void apply_force(const core *c, frame *frames, int32_t i, const double point[3],
                        const double force[3], const double force_change[3])
{
    if (i < 0) return;
    frame *f = frames + i;
    double arm[3], arm_change[3], moment[3], change[3] = {0, 0, 0};
    point_change(c, frames, i, point, arm_change);
    for (int k = 0; k < 3; k++) arm[k] = point[k] - c->origin[3 * i + k], arm_change[k] -= f->shift[k];
    cross3(moment, arm, force);
    add_cross_change(change, arm, arm_change, force, force_change);
    for (int k = 0; k < 3; k++) {
        f->wrench[k] -= moment[k], f->wrench[3 + k] -= force[k];
        f->wrench_change[k] -= change[k], f->wrench_change[3 + k] -= force_change[k];
    }
}

/* A cable pulls the ends of a segment towards each other with f u. */
static void apply_segment(const core *c, frame *frames, int32_t k, double force, double force_change)
{
    const double *A = c->point + 3 * k, *B = A + 3;
    const int32_t a = c->blob.point_frame[k], b = c->blob.point_frame[k + 1];
    double u[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]}, dA[3], dB[3], du[3], pull[3], change[3];
    const double length = sqrt(dot3(u, u));
    if (a == b || length == 0) return;
    point_change(c, frames, a, A, dA);
    point_change(c, frames, b, B, dB);
    for (int j = 0; j < 3; j++) u[j] /= length, du[j] = (dB[j] - dA[j]) / length;
    const double along_u = dot3(u, du);
    for (int j = 0; j < 3; j++) {
        pull[j] = force * u[j];
        change[j] = force_change * u[j] + force * (du[j] - along_u * u[j]);
    }
    apply_force(c, frames, a, A, pull, change);
    for (int j = 0; j < 3; j++) pull[j] = -pull[j], change[j] = -change[j];
    apply_force(c, frames, b, B, pull, change);
}

static void apply_forces(const core *c, frame *frames, const core_tangent *d)
{
    for (int32_t m = 0, k = 0; m < c->blob.counts.muscles; m++, k++)
        for (const int32_t last = k + c->blob.muscle_points[m] - 1; k < last; k++)
            if (d->forces[m] > 0) apply_segment(c, frames, k, d->forces[m], d->forces_change[m]);
    for (int32_t i = 0; i < d->loads; i++) {
        const int32_t task = (int32_t)d->load_tasks[i];
        apply_force(c, frames, c->blob.task_frame[task], c->task_values + 3 * task, d->load + 3 * i,
                    d->load_change + 3 * i);
    }
}

/* ------------------------------------------------------------------------------ inverse dynamics */

/* Spin and acceleration of a frame, and their changes; see motion.c and inverse.c. */
static void move_frame(const core *c, frame *f, const frame *parent, int32_t i, double rate,
                       double rate_change, double qdd)
{
    const int turns = c->blob.motion[i] == ROTATION, at = turns ? 0 : 3;
    const double *axis = c->axis + 3 * i, *r = c->link + 3 * i;
    double own[3], own_change[3];
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
static void add_inertia_change(double out[3], const double I[9], const double turn[3], const double v[3],
                               const double dv[3])
{
    double Iv[3], turned[3], left[3], I_left[3];
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
    const double *centre = c->centre + 3 * i, *I = c->moment + 9 * i, m = c->blob.mass[i];
    const double *alpha = f->motion, *a = f->motion + 3, *dalpha = f->motion_change, *da = dalpha + 3;
    double centre_change[3], Iw[3], Iw_change[3] = {0, 0, 0}, Ia[3];
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

static void collect_changes(const core *c, frame *frames, double *out)
{
    for (int32_t i = c->blob.counts.dofs - 1; i >= 0; i--) {
        const frame *f = frames + i;
        const int at = c->blob.motion[i] == ROTATION ? 0 : 3;
        const double *axis = c->axis + 3 * i, *r = c->link + 3 * i;
        out[c->blob.coordinate[i]] = dot3(f->axis, f->wrench + at) + dot3(axis, f->wrench_change + at);
        if (c->blob.parent[i] < 0) continue;
        frame *parent = frames + c->blob.parent[i];
        for (int k = 0; k < 6; k++)
            parent->wrench[k] += f->wrench[k], parent->wrench_change[k] += f->wrench_change[k];
        add_cross3(parent->wrench, r, f->wrench + 3);
        add_cross_change(parent->wrench_change, r, f->link, f->wrench + 3, f->wrench_change + 3);
    }
}

/* How the generalised forces change that a motion asks for at constant accelerations, in a world that is
   accelerated by `up`; the frames are displaced, and their wrenches hold the forces that act.           */
static void ask(const core *c, frame *frames, const double up[3], const double *qd, const double *dqd,
                const double *qdd, double *out)
{
    frame world;
    memset(&world, 0, sizeof world);
    memcpy(world.motion + 3, up, 3 * sizeof(double));
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        const int32_t j = c->blob.coordinate[i];
        const frame *parent = c->blob.parent[i] < 0 ? &world : frames + c->blob.parent[i];
        move_frame(c, frames + i, parent, i, qd[j], dqd[j], qdd[j]);
        load_frame(c, frames + i, i);
    }
    collect_changes(c, frames, out);
}

static void forget_wrenches(const core *c, frame *frames)
{
    for (int32_t i = 0; i < c->blob.counts.dofs; i++) {
        memset(frames[i].wrench, 0, sizeof frames[i].wrench);
        memset(frames[i].wrench_change, 0, sizeof frames[i].wrench_change);
    }
}

/* ---------------------------------------------------------------------------------------- limits */

/* Impulses on the coordinates that met their limits, by Cholesky's factors of their responses. */
static void solve(const core *c, const work *k, size_t count, double *p)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    for (size_t a = 0; a < count; a++) {
        double *row = k->factor + a * n;
        for (size_t b = 0; b <= a; b++) {
            const double *other = k->factor + b * n;
            double sum = k->response[a * n + (size_t)c->met[b]];
            for (size_t j = 0; j < b; j++) sum -= row[j] * other[j];
            row[b] = a == b ? sqrt(sum) : sum / other[b];
        }
        for (size_t j = 0; j < a; j++) p[a] -= row[j] * p[j];
        p[a] /= row[a];
    }
    for (size_t a = count; a-- > 0;) {
        for (size_t j = a + 1; j < count; j++) p[a] -= k->factor[j * n + a] * p[j];
        p[a] /= k->factor[a * n + a];
    }
}

/* Behind stops qd+ = free + M^-1 p, and (limit - q)/h where a limit is met: M d(qd+ - free) + dM (qd+ -
   free) = dp. `after` is qd+; dqd holds the change of `free` and becomes that of qd+.                   */
static void stop(core *c, work *k, const double *after, const double *dq, double *dqd, double h)
{
    static const double nowhere[3] = {0, 0, 0};
    const size_t dofs = (size_t)c->blob.counts.dofs;
    size_t count = 0;
    for (size_t j = 0; j < dofs; j++)
        if (c->side[j] != 0) c->met[count++] = (double)j;
    if (!count) return;
    double *kick = k->qdd, *p = k->asked;
    for (size_t j = 0; j < dofs; j++) kick[j] = after[j] - k->free[j];
    forget_wrenches(c, k->frames);
    ask(c, k->frames, nowhere, k->still, k->still, kick, k->asked);
    memset(c->armature, 0, dofs * sizeof(double));
    dynamics_factor(c, c->armature);
    dynamics_respond(c, k->asked, k->change);
    for (size_t j = 0; j < dofs; j++) dqd[j] -= k->change[j];
    for (size_t a = 0; a < count; a++) {
        memset(k->change, 0, dofs * sizeof(double));
        k->change[(size_t)c->met[a]] = 1;
        dynamics_respond(c, k->change, k->response + a * dofs);
    }
    for (size_t a = 0; a < count; a++) p[a] = -dq[(size_t)c->met[a]] / h - dqd[(size_t)c->met[a]];
    solve(c, k, count, p);
    for (size_t a = 0; a < count; a++)
        for (size_t j = 0; j < dofs; j++) dqd[j] += p[a] * k->response[a * dofs + j];
    for (size_t a = 0; a < count; a++) dqd[(size_t)c->met[a]] = -dq[(size_t)c->met[a]] / h;
}

/* ------------------------------------------------------------------------------------------ step */

/* J'F of the loads at the last q. */
static void outer_forces(core *c, const core_tangent *d, double *out)
{
    const int32_t dofs = c->blob.counts.dofs;
    memset(out, 0, (size_t)dofs * sizeof(double));
    if (d->loads) core_task_jacobian(c);
    for (int32_t i = 0; i < 3 * d->loads; i++) {
        const size_t row = 3 * (size_t)d->load_tasks[i / 3] + (size_t)(i % 3);
        for (int32_t j = 0; j < dofs; j++)
            out[j] += d->load[i] * c->task_jacobian[row * (size_t)dofs + (size_t)j];
    }
}

/* The changes at the beginning of the step become those of its end; the core is at its beginning. */
static void go_along(core *c, work *k, const core_tangent *d, double h, const double *after)
{
    const blob_view *b = &c->blob;
    const double up[3] = {-b->gravity[0], -b->gravity[1], -b->gravity[2]};
    double *dq = d->q_change, *dqd = d->qd_change;
    core_pull(c, d->forces);
    outer_forces(c, d, c->load);
    for (int32_t j = 0; j < b->counts.dofs; j++) {
        c->armature[j] = h * (b->damping[j] + h * b->stiffness[j]);
        c->load[j] += c->torques[j] - b->damping[j] * k->begin_qd[j] -
                      b->stiffness[j] * (k->begin_q[j] + h * k->begin_qd[j] - b->rest[j]);
    }
    core_accelerate(c, k->begin_qd, c->load, c->armature);
    memcpy(k->qdd, c->qdd, (size_t)b->counts.dofs * sizeof(double));
    displace(c, k->frames, dq);
    forget_wrenches(c, k->frames);
    apply_forces(c, k->frames, d);
    ask(c, k->frames, up, k->begin_qd, dqd, k->qdd, k->asked);
    for (int32_t j = 0; j < b->counts.dofs; j++)
        k->asked[j] = -k->asked[j] - b->damping[j] * dqd[j] - b->stiffness[j] * (dq[j] + h * dqd[j]);
    dynamics_respond(c, k->asked, k->change);
    for (int32_t j = 0; j < b->counts.dofs; j++) dqd[j] += h * k->change[j];
    stop(c, k, after, dq, dqd, h);
    for (int32_t j = 0; j < b->counts.dofs; j++) dq[j] += h * dqd[j];
}

int core_step_along(core *c, const core_tangent *d, double h)
{
    const size_t size = (size_t)c->blob.counts.dofs * sizeof(double);
    work k = placed(c, d->memory);
    memcpy(k.begin_q, c->q, size);
    memcpy(k.begin_qd, c->qd, size);
    outer_forces(c, d, k.asked);
    const int bad = core_step(c, d->forces, k.asked, h, 1);
    if (bad) return bad;
    memcpy(k.free, c->free, size); /* if any limit is met */
    core_move(c, k.begin_q);
    go_along(c, &k, d, h, c->qd);
    core_move(c, c->q);
    return 0;
}
