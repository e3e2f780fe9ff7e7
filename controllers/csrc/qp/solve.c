/* The Newton iteration, and the alternatives if it does not converge. */
#include "state.h"

#include <math.h>
#include <string.h>

/* Maximum numbers of steps, in addition to those of the interior point method. */
enum { MAX_STEPS = 24, STEPS_OF_A_WARM_START = 4 };

/* Regularisation of the Newton matrix, for rows that depend on each other or too few variables between their
   bounds: in this case a step is long, and the line search limits it. */
static const real RIDGE = PRECISE(1e-13, 2e-7);

/* Tolerance of a row, relative to its terms. */
static const real TOLERANCE = PRECISE(1e-13, 1e-5);

/* Return whether the problem is infeasible: the residual at the minimum violation is a proof, and so is a
   direction without a maximum. The check costs as much as half a step, so it is skipped in the first steps. */
static int is_infeasible(dual_newton *s, int peak_is_far)
{
    if (!peak_is_far && s->steps <= STEPS_OF_A_WARM_START) return 0;
    return is_proof(s, s->d) || is_proof(s, s->r);
}

/* Step to the maximum of the dual function minus ridge/2 |t d|^2. Return whether it is beyond every
   breakpoint. */
static int step_to_peak(dual_newton *s)
{
    int is_far;
    add(s->m, s->lam, search_peak(s, RIDGE, &is_far), s->d);
    dual_evaluate(s);
    return is_far;
}

static int newton(dual_newton *s)
{
    dual_evaluate(s);
    for (int step = 0; step < MAX_STEPS; step++) {
        factor_build(s, RIDGE);
        factor_solve(s, s->r, s->d);
        dual_direction(s);
        s->steps++;
        if (polish(s, TOLERANCE)) return DUAL_NEWTON_SOLVED;
        if (is_infeasible(s, step_to_peak(s))) return DUAL_NEWTON_INFEASIBLE;
    }
    return DUAL_NEWTON_NOT_CONVERGED;
}

/* Convert x to the scale of the caller; a variable at its bound gets exactly the bound. */
static void export_x(dual_newton *s)
{
    for (size_t j = 0; j < s->m; j++) s->slack[j] = -s->b[j];
    for (size_t i = 0; i < s->n; i++) {
        const real x = s->sx[i] / s->root[i];
        if (s->sx[i] <= s->low[i])
            s->x[i] = s->lb[i];
        else
            s->x[i] = s->sx[i] >= s->high[i] ? s->ub[i] : clip(x, s->lb[i], s->ub[i]);
        add(s->m, s->slack, s->x[i], s->A + i * s->m);
    }
}

static void export_multipliers(dual_newton *s, const real *lam)
{
    for (size_t j = 0; j < s->m; j++) s->multipliers[j] = lam[j] / s->norm[j];
}

int dual_newton_solve(dual_newton *s)
{
    s->steps = 0;
    const int wrong = scale_problem(s);
    if (wrong) return wrong;
    int status = newton(s);
    if (status == DUAL_NEWTON_NOT_CONVERGED) status = interior_point(s);
    if (status != DUAL_NEWTON_SOLVED) measure(s);
    export_x(s);
    export_multipliers(s, status == DUAL_NEWTON_INFEASIBLE ? s->correction : s->lam);
    if (status == DUAL_NEWTON_SOLVED) memcpy(s->start, s->multipliers, s->m * sizeof(real));
    return status;
}
