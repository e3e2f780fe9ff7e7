/* Poses with closed loops, from any start: damped least squares (Levenberg-Marquardt),

     dq = -J' (J J' + m 1)^-1 phi,

   with the gaps of directions as angles, so that no joint closes with the wrong orientation. If a start
   leads to a dead end, such as a stretched pose, other starts near it are used, always in the same order. */
#include "../kinematics/tree.h"
#include "../math/elementary.h"
#include "closures.h"

#include <string.h>

enum { STEPS = 100, STARTS = 12 };

/* In [m] or [rad]: tolerance of closed loops, and maximum step. */
static const real CLOSED_POSE = PRECISE(1e-10, 1e-5), MAX_STEP = 0.5;

/* Gap that remains if files with rounded positions contradict themselves, such as the distance of two
   planes in a planar loop: no motion changes it, and the other equations hold. */
static const real MAX_REMAINING = PRECISE(1e-6, 1e-4), STALLED = PRECISE(1e-12, 1e-6);

/* Tolerance of a start that is closed and stays as it is. */
static const real CLOSED_START = PRECISE(1e-12, 1e-6);

static real worst_gap(const core *c)
{
    return fabs(c->closure_gap[closures_worst(c)]);
}

/* Factorise J J' + m 1 and solve for the gaps, in closure_force. */
static void solve_gaps(core *c)
{
    const int32_t closures = c->blob.counts.closures, dofs = c->blob.counts.dofs;
    real *p = c->closure_force, squares = 0, largest = 0;
    for (int32_t k = 0; k < closures; k++) squares += c->closure_gap[k] * c->closure_gap[k];
    for (int32_t a = 0; a < closures; a++) {
        const real *Ja = c->closure_jacobian + (size_t)a * (size_t)dofs;
        for (int32_t b = 0; b <= a; b++) {
            const real *Jb = c->closure_jacobian + (size_t)b * (size_t)dofs;
            real sum = 0;
            for (int32_t j = 0; j < dofs; j++) sum += Ja[j] * Jb[j];
            c->closure_factor[(size_t)a * (size_t)closures + (size_t)b] = sum;
        }
        largest = larger(largest, c->closure_factor[(size_t)a * (size_t)closures + (size_t)a]);
    }
    const real damping = largest > 0 ? PRECISE(1e-12, 1e-6) * largest + 0.01 * smaller(squares, largest) : 1;
    for (int32_t a = 0; a < closures; a++) {
        real *La = c->closure_factor + (size_t)a * (size_t)closures;
        La[a] += damping;
        p[a] = -c->closure_gap[a];
        for (int32_t b = 0; b <= a; b++) {
            const real *Lb = c->closure_factor + (size_t)b * (size_t)closures;
            for (int32_t k = 0; k < b; k++) La[b] -= La[k] * Lb[k];
            La[b] = a == b ? sqrt(larger(La[a], PRECISE(1e-3, 1e-2) * damping)) : La[b] / Lb[b];
        }
        for (int32_t k = 0; k < a; k++) p[a] -= La[k] * p[k];
        p[a] /= La[a];
    }
    for (int32_t a = closures; a-- > 0;) {
        for (int32_t k = a + 1; k < closures; k++) p[a] -= c->closure_factor[(size_t)k * (size_t)closures + (size_t)a] * p[k];
        p[a] /= c->closure_factor[(size_t)a * (size_t)closures + (size_t)a];
    }
}

/* Take one step within the limits and return its largest change. Coordinates that would leave them are held at
   the limit in the next step. */
static real reduce_gaps(core *c, const real *held, real *q)
{
    const int32_t closures = c->blob.counts.closures, dofs = c->blob.counts.dofs;
    real maximum = 0;
    for (int32_t j = 0; j < dofs; j++)
        if ((held && held[j] != 0) || c->side[j] != 0)
            for (int32_t k = 0; k < closures; k++) c->closure_jacobian[(size_t)k * (size_t)dofs + (size_t)j] = 0;
    solve_gaps(c);
    for (int32_t j = 0; j < dofs; j++) {
        real sum = 0;
        for (int32_t k = 0; k < closures; k++)
            sum += c->closure_force[k] * c->closure_jacobian[(size_t)k * (size_t)dofs + (size_t)j];
        c->closing[j] = sum;
        maximum = larger(maximum, fabs(sum));
    }
    const real share = maximum > MAX_STEP ? MAX_STEP / maximum : 1;
    for (int32_t j = 0; j < dofs; j++) {
        const real next = q[j] + share * c->closing[j], low = c->blob.lower[j], high = c->blob.upper[j];
        c->side[j] = 0;
        if (held && held[j] != 0) continue;
        q[j] = smaller(larger(next, low), high);
        c->side[j] = q[j] != next;
    }
    return maximum;
}

/* Return whether the loops close from the start q. */
static int close_from(core *c, const real *held, real *q)
{
    memset(c->side, 0, (size_t)c->blob.counts.dofs * sizeof(real));
    real before = 0, change = MAX_STEP;
    for (int step = 0; step < STEPS; step++) {
        tree_move(c, q);
        closures_angles(c);
        const real gap = worst_gap(c);
        if (gap <= CLOSED_START || (step > 0 && gap <= CLOSED_POSE && gap >= 0.5 * before)) break;
        if (change < STALLED && gap > CLOSED_POSE && gap <= MAX_REMAINING) break;
        before = gap;
        change = reduce_gaps(c, held, q);
    }
    tree_move(c, q);
    closures_angles(c);
    return worst_gap(c) <= (change < STALLED ? MAX_REMAINING : CLOSED_POSE);
}

int core_close(core *c, const real *held, real *q)
{
    const int32_t dofs = c->blob.counts.dofs;
    if (!c->blob.counts.closures) return 0;
    real *start = c->before, *nearest = c->before + dofs, minimum = 0;
    int is_closed = 0;
    memcpy(start, q, (size_t)dofs * sizeof(real));
    for (int attempt = 0; attempt < STARTS; attempt++) {
        for (int32_t j = 0; j < dofs && attempt > 0; j++) {
            const real golden = 0.6180339887498949, part = (real)((j + 1) * attempt) * golden;
            q[j] = start[j];
            if (!held || held[j] == 0) q[j] += 0.2 * attempt * (part - (real)(int32_t)part - 0.5);
        }
        is_closed = close_from(c, held, q);
        if (attempt == 0 || is_closed || worst_gap(c) < minimum) {
            minimum = worst_gap(c);
            memcpy(nearest, q, (size_t)dofs * sizeof(real));
        }
        if (is_closed) break;
    }
    memcpy(q, nearest, (size_t)dofs * sizeof(real));
    core_move(c, q);
    closures_angles(c);
    return is_closed ? 0 : 1 + closures_worst(c);
}
