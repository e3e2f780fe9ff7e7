/* A step along a direction. The forces that its motion asks for change, at constant accelerations, by
   d(C + G + M qdd - J'F), with F the forces of cables and loads on the points where they act; then the
   accelerations change by what makes up for that:

     (M + h D + h^2 K) dqdd = -d(C + G + M qdd - J'F) - D dqd - K (dq + h dqd)                           */
#include "tangent.h"

#include "tangent_frames.h"

#include <math.h>
#include <string.h>

typedef struct {
    frame *frames;                        /* dofs */
    real *begin_q, *begin_qd, *free;    /* dofs each */
    real *qdd, *asked, *change, *still; /* dofs each */
    real *response, *factor;            /* dofs x dofs */
} work;

size_t core_tangent_size(const core *c)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    if (c->has_laws || c->has_friction || c->blob.counts.wraps || c->blob.counts.pulleys) return 0;
    return dofs * (sizeof(frame) / sizeof(real) + 7) + 2 * dofs * dofs;
}

static work placed(const core *c, real *memory)
{
    const size_t dofs = (size_t)c->blob.counts.dofs;
    work k = {.frames = (frame *)(void *)memory};
    real **const vectors[] = {&k.begin_q, &k.begin_qd, &k.free, &k.qdd, &k.asked, &k.change, &k.still};
    real *at = memory + dofs * (sizeof(frame) / sizeof(real));
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++, at += dofs) *vectors[i] = at;
    memset(k.still, 0, dofs * sizeof(real));
    k.response = at;
    k.factor = at + dofs * dofs;
    return k;
}

/* ---------------------------------------------------------------------------------------- forces */

/* A cable pulls the ends of a segment towards each other with f u. */
static void apply_segment(const core *c, frame *frames, int32_t k, real force, real force_change)
{
    const real *A = c->point + 3 * k, *B = A + 3;
    const int32_t a = c->blob.point_frame[k], b = c->blob.point_frame[k + 1];
    real u[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]}, dA[3], dB[3], du[3], pull[3], change[3];
    const real length = sqrt(dot3(u, u));
    if (a == b || length == 0) return;
    tangent_point(c, frames, a, A, dA);
    tangent_point(c, frames, b, B, dB);
    for (int j = 0; j < 3; j++) u[j] /= length, du[j] = (dB[j] - dA[j]) / length;
    const real along_u = dot3(u, du);
    for (int j = 0; j < 3; j++) {
        pull[j] = force * u[j];
        change[j] = force_change * u[j] + force * (du[j] - along_u * u[j]);
    }
    tangent_apply(c, frames, a, A, pull, change);
    for (int j = 0; j < 3; j++) pull[j] = -pull[j], change[j] = -change[j];
    tangent_apply(c, frames, b, B, pull, change);
}

static void apply_forces(const core *c, frame *frames, const core_tangent *d)
{
    for (int32_t m = 0, k = 0; m < c->blob.counts.muscles; m++, k++)
        for (const int32_t last = k + c->blob.muscle_points[m] - 1; k < last; k++)
            if (d->forces[m] > 0) apply_segment(c, frames, k, d->forces[m], d->forces_change[m]);
    for (int32_t i = 0; i < d->loads; i++) {
        const int32_t task = (int32_t)d->load_tasks[i];
        tangent_apply(c, frames, c->blob.task_frame[task], c->task_values + 3 * task, d->load + 3 * i,
                    d->load_change + 3 * i);
    }
}

/* ---------------------------------------------------------------------------------------- limits */

/* Impulses on the coordinates that met their limits, by Cholesky's factors of their responses. */
static void solve(const core *c, const work *k, size_t count, real *p)
{
    const size_t n = (size_t)c->blob.counts.dofs;
    for (size_t a = 0; a < count; a++) {
        real *row = k->factor + a * n;
        for (size_t b = 0; b <= a; b++) {
            const real *other = k->factor + b * n;
            real sum = k->response[a * n + (size_t)c->met[b]];
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
static void stop(core *c, work *k, const real *after, const real *dq, real *dqd, real h)
{
    static const real nowhere[3] = {0, 0, 0};
    const size_t dofs = (size_t)c->blob.counts.dofs;
    size_t count = 0;
    for (size_t j = 0; j < dofs; j++)
        if (c->side[j] != 0) c->met[count++] = (real)j;
    if (!count) return;
    real *kick = k->qdd, *p = k->asked;
    for (size_t j = 0; j < dofs; j++) kick[j] = after[j] - k->free[j];
    tangent_forget(c, k->frames);
    tangent_ask(c, k->frames, nowhere, k->still, k->still, kick, k->asked);
    memset(c->armature, 0, dofs * sizeof(real));
    dynamics_factor(c, c->armature);
    dynamics_respond(c, k->asked, k->change);
    for (size_t j = 0; j < dofs; j++) dqd[j] -= k->change[j];
    for (size_t a = 0; a < count; a++) {
        memset(k->change, 0, dofs * sizeof(real));
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
static void outer_forces(core *c, const core_tangent *d, real *out)
{
    const int32_t dofs = c->blob.counts.dofs;
    memset(out, 0, (size_t)dofs * sizeof(real));
    if (d->loads) core_task_jacobian(c);
    for (int32_t i = 0; i < 3 * d->loads; i++) {
        const size_t row = 3 * (size_t)d->load_tasks[i / 3] + (size_t)(i % 3);
        for (int32_t j = 0; j < dofs; j++)
            out[j] += d->load[i] * c->task_jacobian[row * (size_t)dofs + (size_t)j];
    }
}

/* The changes at the beginning of the step become those of its end; the core is at its beginning. */
static void go_along(core *c, work *k, const core_tangent *d, real h, const real *after)
{
    const blob_view *b = &c->blob;
    const real up[3] = {-b->gravity[0], -b->gravity[1], -b->gravity[2]};
    real *dq = d->q_change, *dqd = d->qd_change;
    core_pull(c, d->forces);
    outer_forces(c, d, c->load);
    for (int32_t j = 0; j < b->counts.dofs; j++) {
        c->armature[j] = h * (b->damping[j] + h * b->stiffness[j]);
        c->load[j] += c->torques[j] - b->damping[j] * k->begin_qd[j] -
                      b->stiffness[j] * (k->begin_q[j] + h * k->begin_qd[j] - b->rest[j]);
    }
    core_accelerate(c, k->begin_qd, c->load, c->armature);
    memcpy(k->qdd, c->qdd, (size_t)b->counts.dofs * sizeof(real));
    tangent_displace(c, k->frames, dq);
    tangent_forget(c, k->frames);
    apply_forces(c, k->frames, d);
    tangent_ask(c, k->frames, up, k->begin_qd, dqd, k->qdd, k->asked);
    for (int32_t j = 0; j < b->counts.dofs; j++)
        k->asked[j] = -k->asked[j] - b->damping[j] * dqd[j] - b->stiffness[j] * (dq[j] + h * dqd[j]);
    dynamics_respond(c, k->asked, k->change);
    for (int32_t j = 0; j < b->counts.dofs; j++) dqd[j] += h * k->change[j];
    stop(c, k, after, dq, dqd, h);
    for (int32_t j = 0; j < b->counts.dofs; j++) dq[j] += h * dqd[j];
}

int core_step_along(core *c, const core_tangent *d, real h)
{
    const size_t size = (size_t)c->blob.counts.dofs * sizeof(real);
    work k = placed(c, d->memory);
    memcpy(k.begin_q, c->q, size);
    memcpy(k.begin_qd, c->qd, size);
    outer_forces(c, d, k.asked);
    memset(c->side, 0, size); /* a step that meets no limit leaves those of the last one that did */
    const int bad = core_step(c, d->forces, k.asked, h, 1);
    if (bad) return bad;
    memcpy(k.free, c->free, size); /* if any limit is met */
    core_move(c, k.begin_q);
    go_along(c, &k, d, h, c->qd);
    core_move(c, c->q);
    return 0;
}
