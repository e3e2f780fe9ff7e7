/* Geodesics on an ellipsoid, by Taylor series.

   On x'Ax = 1, A = diag(1/r^2), the acceleration is normal to the surface, along Ax, with the magnitude that
   keeps x on it. With g = |Ax|^2 the number D = (v'Av) g is constant along a geodesic (Joachimsthal), and
   the curvature of the surface is K = det(A) / g^2. So the geodesic, with its length s as parameter, and the
   distance j of a neighbouring geodesic (Jacobi's equation, j'' = -K j) solve

     x'' = -D w A x,     j'' = -det(A) w j,     w = g^-2.

   The coefficients of the Taylor series are computed recursively: those of g are sums of products of those
   of x, and from g w' = -2 g' w

     n g_0 w_n = - sum_{k=1..n} (n + k) g_k w_{n-k}.

   The curvature of the geodesic is |x''| = D g^(-3/2), a power whose recursion has n + k / 2 instead of n +
   k. The last coefficients determine the number of terms and the length of each step. */
#include "geodesic.h"

#include "../../math/elementary.h"

#include <math.h>
#include <stddef.h>

#define ORDER 16 /* maximum; a power of 2, so that roots are square roots */
#define MIN_ORDER 6
#define MAX_STEPS 64
#define SAME_STEP 1.001 /* ratio of a step and its rounded value */

/* Coefficients; x and j are stored together, so that processors vectorise them, and so are g_n and n g_n. */
typedef struct {
    real c[ORDER + 1][4], g[ORDER + 1][2], w[ORDER + 1], other[ORDER + 1];
    int order;
} taylor;

/* Return coefficient n of a power of g from the others: `per` is 1 for g^-2, 0.5 for g^(-3/2). */
static real next_of_power(const taylor *t, const real *power, int n, real per)
{
    real falls[2] = {0, 0};
    for (int k = 1; k <= n; k++)
        for (int i = 0; i < 2; i++) falls[i] += t->g[k][i] * power[n - k];
    return -(n * falls[0] + per * falls[1]) * (1 / (n * t->g[0][0]));
}

static void expand_weight(const real square[3], int n, taylor *t)
{
    real sums[4] = {0, 0, 0, 0}, sum = 0;
    for (int k = 0; 2 * k < n; k++)
        for (int i = 0; i < 4; i++) sums[i] += 2 * t->c[k][i] * t->c[n - k][i];
    for (int i = 0; i < 4 && n % 2 == 0; i++) sums[i] += t->c[n / 2][i] * t->c[n / 2][i];
    for (int i = 0; i < 3; i++) sum += square[i] * sums[i];
    t->g[n][0] = sum, t->g[n][1] = n * sum;
    t->w[n] = n ? next_of_power(t, t->w, n, 1) : 1 / (sum * sum);
}

/* Return the sum of the last two coefficients. */
static real last_terms(const taylor *t)
{
    real last = 0;
    for (int n = t->order - 1; n <= t->order; n++) {
        last += fabs(value_of(t->other[n]));
        for (int i = 0; i < 4; i++) last += fabs(value_of(t->c[n][i]));
    }
    return last;
}

/* Expand the geodesic, and another neighbouring geodesic unless `field` is NULL, until the last terms of a step h
   are small. Return whether they are. */
static int expand_until_small(const real A[3], const geodesic_point *p, const real field[2], real h, real last_term, taylor *t)
{
    const real square[3] = {A[0] * A[0], A[1] * A[1], A[2] * A[2]};
    real along = 0, g = 0, power = h;
    for (int i = 0; i < 3; i++) {
        t->c[0][i] = p->x[i], t->c[1][i] = p->v[i];
        along += A[i] * p->v[i] * p->v[i], g += square[i] * p->x[i] * p->x[i];
    }
    t->c[0][3] = p->j, t->c[1][3] = p->dj;
    t->other[0] = field ? field[0] : 0, t->other[1] = field ? field[1] : 0;
    const real D = along * g, factor[4] = {-D * A[0], -D * A[1], -D * A[2], -A[0] * A[1] * A[2]};
    for (int n = 0; n + 2 <= ORDER; n++) {
        real sums[4] = {0, 0, 0, 0}, sum = 0;
        expand_weight(square, n, t);
        for (int k = n; k >= 0; k--)
            for (int i = 0; i < 4; i++) sums[i] += t->w[n - k] * t->c[k][i];
        const real per = 1.0 / ((n + 1) * (n + 2));
        for (int i = 0; i < 4; i++) t->c[n + 2][i] = per * factor[i] * sums[i];
        for (int k = 0; k <= n && field; k++) sum += t->w[n - k] * t->other[k];
        t->other[n + 2] = per * factor[3] * sum;
        t->order = n + 2, power *= h;
        if (n % 2 == 0 && n + 2 >= MIN_ORDER && value_of(last_terms(t) * power) <= value_of(last_term)) return 1;
    }
    return 0;
}

/* Return the step with which the last term at the maximum order is small. */
static real longest_step(const taylor *t, real last_term)
{
    const real last = last_terms(t);
    real h = value_of(last) > 0 ? last_term / last : 1;
    for (int root = ORDER; root > 1; root /= 2) h = sqrt(h);
    return value_of(h);
}

/* Evaluate all series at h, and their derivatives. */
static void sum_series(const taylor *t, real h, geodesic_point *p)
{
    real sum[4] = {0, 0, 0, 0}, rise[4] = {0, 0, 0, 0};
    for (int n = t->order; n >= 0; n--)
        for (int i = 0; i < 4; i++) rise[i] = rise[i] * h + sum[i], sum[i] = sum[i] * h + t->c[n][i];
    for (int i = 0; i < 3; i++) p->x[i] = sum[i], p->v[i] = rise[i];
    p->j = sum[3], p->dj = rise[3];
}

static void sum_field(const taylor *t, real h, real field[2])
{
    field[0] = field[1] = 0;
    for (int n = t->order; n >= 0; n--) field[1] = field[1] * h + field[0], field[0] = field[0] * h + t->other[n];
}

/* Return the integral of the curvature over h. */
static real bend_within(const real A[3], const taylor *t, real h)
{
    real power[ORDER - 1], along = 0, sum = 0;
    for (int i = 0; i < 3; i++) along += A[i] * t->c[1][i] * t->c[1][i];
    power[0] = 1 / (t->g[0][0] * sqrt(t->g[0][0]));
    for (int n = 1; n < t->order - 1; n++) power[n] = next_of_power(t, power, n, 0.5);
    for (int n = t->order - 2; n >= 0; n--) sum = sum * h + power[n] / (n + 1);
    return along * t->g[0][0] * sum * h;
}

void geodesic_follow(const real half_axes[3], real way, real last_term, geodesic_point *p, real field[2],
                     real *bend)
{
    taylor t;
    real A[3], left = way, h = fabs(way);
    for (int i = 0; i < 3; i++) A[i] = 1 / (half_axes[i] * half_axes[i]);
    for (int step = 1;; step++) {
        if (!expand_until_small(A, p, field, h, last_term, &t)) { /* in equal steps */
            const real distance = fabs(left), most = longest_step(&t, last_term);
            const int count = 1 + (int)value_of(smaller(distance / most, MAX_STEPS));
            if (value_of(most) < value_of(h)) h = distance / count;
        }
        const int is_last = value_of(fabs(left)) <= value_of(SAME_STEP * h) || step == MAX_STEPS;
        const real change = is_last ? left : value_of(left) > 0 ? h : -h;
        sum_series(&t, change, p);
        if (field) sum_field(&t, change, field);
        if (bend) *bend += bend_within(A, &t, change);
        if (is_last) return;
        left -= change;
    }
}
