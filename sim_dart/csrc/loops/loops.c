/* Loop joints as constraints of Gauss's principle: of all rates x that keep the loops closed, J x = b,
   choose those nearest to the rates x0 of the tree,

     min 1/2 (x - x0)' M (x - x0)   s.t.  J x = b:     (J M^-1 J') p = b - J x0,   x = x0 + M^-1 J' p.

   In general closures depend on each other, for example those of a planar loop in space. J M^-1 J' is
   factorised by pivoted Cholesky factorisation. Rows whose pivot is below a share of the largest one are
   ignored: the other closures imply them, or, in a singular pose of a mechanism, its motion does. */
#include "loops.h"

#include "../dynamics/forward.h"
#include "../kinematics/bodies.h"
#include "../math/elementary.h"
#include "../math/vectors.h"
#include "closures.h"

#include <string.h>

/* Minimum pivot relative to the largest one. */
static const real MIN_SHARE = PRECISE(1e-9, 1e-5);

/* Tolerance of a closed gap, in [m] or as a cosine: the next Newton step would leave its square. */
static const real CLOSED = PRECISE(1e-9, 1e-4);

/* Maximum closing velocity of a gap, in m/s or 1/s. */
static const real MAX_CLOSING = 10;

static real product(const core *c, const real *a, const real *b)
{
    real sum = 0;
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) sum += a[j] * b[j];
    return sum;
}

static real *row_of(const core *c, real *matrix, int32_t k)
{
    return matrix + (size_t)k * (size_t)c->blob.counts.dofs;
}

/* Compute the diagonal of J M^-1 J' at the place of the factor, and M^-1 J'; rows of zeros are ignored. */
static void respond_closures(core *c)
{
    const int32_t closures = c->blob.counts.closures;
    real largest = 0;
    for (int32_t k = 0; k < closures; k++) {
        const real *J = row_of(c, c->closure_jacobian, k);
        largest = larger(largest, c->closure_pivot[k] = product(c, J, J));
    }
    for (int32_t k = 0; k < closures; k++) {
        const real *J = row_of(c, c->closure_jacobian, k);
        const int is_ignored = value_of(c->closure_pivot[k]) <= value_of(1e-6 * MIN_SHARE * largest);
        c->closure_pivot[k] = 0;
        if (is_ignored) continue;
        dynamics_respond(c, J, row_of(c, c->closure_response, k));
        c->closure_pivot[k] = product(c, J, row_of(c, c->closure_response, k));
    }
}

/* Move the closure with the largest pivot, from `rank` on, to `rank`. */
static int32_t largest_pivot(core *c, int32_t rank)
{
    int32_t best = rank;
    for (int32_t t = rank + 1; t < c->blob.counts.closures; t++)
        if (value_of(c->closure_pivot[(int32_t)value_of(c->closure_order[t])]) >
            value_of(c->closure_pivot[(int32_t)value_of(c->closure_order[best])]))
            best = t;
    const real chosen = c->closure_order[best];
    c->closure_order[best] = c->closure_order[rank];
    c->closure_order[rank] = chosen;
    return (int32_t)value_of(chosen);
}

void loops_factor(core *c)
{
    const int32_t closures = c->blob.counts.closures;
    respond_closures(c);
    for (int32_t k = 0; k < closures; k++) c->closure_order[k] = k;
    real least = 0;
    for (c->closure_rank = 0; c->closure_rank < closures; c->closure_rank++) {
        const int32_t rank = c->closure_rank, i = largest_pivot(c, rank);
        real *Li = c->closure_factor + (size_t)i * (size_t)closures;
        if (rank == 0) least = MIN_SHARE * c->closure_pivot[i];
        if (value_of(c->closure_pivot[i]) <= value_of(least)) break;
        Li[rank] = sqrt(c->closure_pivot[i]);
        for (int32_t t = rank + 1; t < closures; t++) {
            const int32_t j = (int32_t)value_of(c->closure_order[t]);
            if (value_of(c->closure_pivot[j]) <= value_of(least)) continue;
            real *Lj = c->closure_factor + (size_t)j * (size_t)closures;
            real sum = product(c, row_of(c, c->closure_jacobian, j), row_of(c, c->closure_response, i));
            for (int32_t s = 0; s < rank; s++) sum -= Lj[s] * Li[s];
            Lj[rank] = sum / Li[rank];
            c->closure_pivot[j] -= Lj[rank] * Lj[rank];
        }
    }
}

/* Compute closure_force: p of L L' p = closure_force, in the order of the pivots. */
static void solve_forces(core *c)
{
    const size_t closures = (size_t)c->blob.counts.closures;
    real *p = c->closure_force;
    for (int32_t s = 0; s < c->closure_rank; s++) {
        const real *L = c->closure_factor + (size_t)value_of(c->closure_order[s]) * closures;
        for (int32_t k = 0; k < s; k++) p[s] -= L[k] * p[k];
        p[s] /= L[s];
    }
    for (int32_t s = c->closure_rank; s-- > 0;) {
        for (int32_t k = s + 1; k < c->closure_rank; k++)
            p[s] -= c->closure_factor[(size_t)value_of(c->closure_order[k]) * closures + (size_t)s] * p[k];
        p[s] /= c->closure_factor[(size_t)value_of(c->closure_order[s]) * closures + (size_t)s];
    }
}

void loops_project(core *c, const real *goal, real *rates)
{
    for (int32_t s = 0; s < c->closure_rank; s++) {
        const int32_t k = (int32_t)value_of(c->closure_order[s]);
        c->closure_force[s] = (goal ? goal[k] : 0) - product(c, row_of(c, c->closure_jacobian, k), rates);
    }
    solve_forces(c);
    for (int32_t s = 0; s < c->closure_rank; s++) {
        const real *response = row_of(c, c->closure_response, (int32_t)value_of(c->closure_order[s]));
        for (int32_t j = 0; j < c->blob.counts.dofs; j++) rates[j] += c->closure_force[s] * response[j];
    }
}

void loops_respond(core *c, const real *impulse, real *change)
{
    dynamics_respond(c, impulse, change);
    if (c->closure_rank) loops_project(c, NULL, change);
}

void loops_enforce(core *c, real h)
{
    closures_move(c);
    loops_factor(c);
    for (int32_t k = 0; k < c->blob.counts.closures; k++)
        c->closure_bias[k] = larger(smaller(-c->closure_gap[k] / h, MAX_CLOSING), -MAX_CLOSING);
    loops_project(c, c->closure_bias, c->qd);
}

/* Factorise everything at the last q. */
static void factor_all(core *c)
{
    bodies_links(c);
    bodies_inertias(c);
    dynamics_factor(c, c->blob.armature);
    closures_move(c);
    loops_factor(c);
}

void loops_close(core *c)
{
    for (int round = 0; round < 10; round++) {
        factor_all(c);
        const int is_last = value_of(fabs(c->closure_gap[closures_worst(c)])) <= value_of(CLOSED);
        for (int32_t k = 0; k < c->blob.counts.closures; k++) c->closure_bias[k] = -c->closure_gap[k];
        memset(c->closing, 0, (size_t)c->blob.counts.dofs * sizeof(real));
        loops_project(c, c->closure_bias, c->closing);
        for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->q[j] += c->closing[j];
        core_move(c, c->q);
        if (is_last) break;
    }
    factor_all(c);
    loops_project(c, NULL, c->qd);
}

void core_close_rates(core *c, real *qd)
{
    if (!c->blob.counts.closures) return;
    factor_all(c);
    loops_project(c, NULL, qd);
}

void core_accelerate(core *c, const real *qd, const real *tau, const real *armature)
{
    dynamics_accelerate(c, qd, tau, armature);
    if (!c->blob.counts.closures) return;
    closures_move(c);
    closures_bias(c);
    loops_factor(c);
    for (int32_t k = 0; k < c->blob.counts.closures; k++) c->closure_bias[k] = -c->closure_bias[k];
    loops_project(c, c->closure_bias, c->qdd);
}
