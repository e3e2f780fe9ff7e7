/* The iterations of the interior-point method. */
#include "riccati.h"
#include "stage_bounds.h"

static const real INTERIOR = 0.995; /* share of the distance to a bound */

static int update_status(stage_qp *s)
{
    s->gap = stage_bounds_complementarity(s, 0, 0, 0);
    if (!isfinite(s->gap)) return STAGE_QP_FAILED;
    return s->gap <= s->tolerance[0] && s->rest <= s->tolerance[1] ? STAGE_QP_SOLVED : STAGE_QP_NOT_CONVERGED;
}

int stage_qp_begin(stage_qp *s)
{
    s->steps = 0, s->rest = 1;
    riccati_residuals(s);
    stage_bounds_start(s);
    return update_status(s);
}

/* Compute the step for the complementarity m. Return its largest length up to 2. */
static real solve_step(stage_qp *s, real m)
{
    stage_bounds_push(s, m);
    riccati_solve(s);
    return stage_bounds_reach(s, m);
}

/* Mehrotra: a predictor with m = 0 determines m of the corrector. */
int stage_qp_iterate(stage_qp *s)
{
    riccati_residuals(s);
    stage_bounds_weigh(s);
    if (riccati_factorize(s)) return STAGE_QP_FAILED;
    real length = smaller(solve_step(s, 0), 1), m = 0;
    if (s->gap > 0) {
        const real after = stage_bounds_complementarity(s, 0, length, 1), share = after / s->gap;
        m = share * share * after;
        length = smaller(INTERIOR * solve_step(s, m), 1);
    }
    stage_bounds_apply(s, m, length);
    add(s->total, s->v, length, s->step);
    s->rest *= 1 - length;
    s->steps++;
    return update_status(s);
}
