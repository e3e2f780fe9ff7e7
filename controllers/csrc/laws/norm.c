/* min sum |H^1/2 (f - f_p)|^p by Newton's method: a quadratic program computes each step, and a line search
   minimises the power along it. The norms 1 and infinity are linear programs, see ../qp/linear.h. */
#include "norm.h"

#include "../qp/linear.h"
#include "program.h"

#include <math.h>
#include <string.h>

enum { STEPS = 60, HALVINGS = 40 };
static const real MIN_DECREASE = PRECISE(1e-15, 1e-7);  /* relative decrease of the power in the last step */
static const real MIN_CURVATURE = PRECISE(1e-12, 1e-6); /* minimum curvature, relative to the maximum */

static real power(real z, int p)
{
    real product = 1;
    for (int i = 0; i < p; i++) product *= z;
    return product;
}

/* Return z |z|^(p - 2). */
static real slope_at(real z, int p)
{
    return z < 0 ? -power(-z, p - 1) : power(z, p - 1);
}

static int decreases(const computed_torque *s, int p, real t)
{
    real slope = 0;
    for (size_t i = 0; i < s->m; i++) slope += slope_at(s->apart[i] + t * s->way[i], p) * s->way[i];
    return slope <= 0;
}

static real minimize_on_line(const computed_torque *s, int p)
{
    real low = 0, high = 1;
    if (decreases(s, p, 1)) return 1;
    for (int i = 0; i < HALVINGS; i++) {
        const real t = (real)0.5 * (low + high);
        if (decreases(s, p, t)) low = t;
        else high = t;
    }
    return low;
}

/* Compute the second-order model of the norm at the forces: the cost of the program, and `apart` in units of
   size. Return the power. */
static real model_at(computed_torque *s, int p, real size)
{
    real sum = 0;
    for (size_t i = 0; i < s->m; i++) {
        const real unit = sqrt(s->H_f[i]) / size, z = unit * (s->forces[i] - s->f_p[i]), away = fabs(z);
        const real curve = (real)(p - 1) * unit * unit * larger(power(away, p - 2), MIN_CURVATURE);
        s->apart[i] = z, sum += power(away, p);
        s->hard->H_diagonal[i] = curve;
        s->hard->g[i] = unit * slope_at(z, p) - curve * s->forces[i];
    }
    return sum;
}

/* Continue from the least-squares forces with the minimum 1-norm or infinity norm. */
static int minimize_linear_norm(computed_torque *s)
{
    real *counts = s->apart;
    for (size_t i = 0; i < s->m; i++) counts[i] = sqrt(s->H_f[i]);
    const box bounds = {s->f_min, s->f_max};
    const int status = isfinite(s->norm[0])
                           ? minimize_sum(s->hard, second_program(s, 2 * s->m), bounds, counts, s->f_p, s->forces)
                           : minimize_largest(s->hard, bounds, counts, s->f_p, s->forces);
    if (status == DUAL_NEWTON_SOLVED) memcpy(s->forces, s->hard->x, s->m * sizeof(real));
    return status;
}

int norm_minimize(computed_torque *s)
{
    if (s->norm[0] == 1 || s->norm[0] == INFINITY) return minimize_linear_norm(s);
    const int p = (int)s->norm[0];
    dual_newton *program = s->hard;
    real size = 0;
    for (size_t i = 0; i < s->m; i++) size = larger(size, sqrt(s->H_f[i]) * fabs(s->forces[i] - s->f_p[i]));
    if (p <= 2 || size == 0) return DUAL_NEWTON_SOLVED;
    memcpy(s->squares, s->forces, s->m * sizeof(real));
    memset(program->start, 0, program->m * sizeof(real));
    for (int step = 0; step < STEPS; step++) {
        const real sum = model_at(s, p, size);
        const int status = dual_newton_solve(program);
        if (status != DUAL_NEWTON_SOLVED) {
            memcpy(s->forces, s->squares, s->m * sizeof(real));
            return status;
        }
        real lower = 0;
        for (size_t i = 0; i < s->m; i++) {
            s->way[i] = sqrt(s->H_f[i]) / size * (program->x[i] - s->forces[i]);
            lower -= slope_at(s->apart[i], p) * s->way[i];
        }
        if (lower <= MIN_DECREASE * sum) break;
        const real t = minimize_on_line(s, p);
        for (size_t i = 0; i < s->m; i++) s->forces[i] += t * (program->x[i] - s->forces[i]);
    }
    return DUAL_NEWTON_SOLVED;
}
