/* Geodesics on an ellipsoid, by Taylor series.

   On x'Ax = 1, A = diag(1/r^2), the acceleration is normal to the surface, along Ax, and as large as keeps x
   on it. With g = |Ax|^2 the number D = (v'Av) g stays what it is along a geodesic (Joachimsthal), and the
   curvature of the surface is K = det(A) / g^2. So the geodesic by its length s, and the distance j of one
   beside it (Jacobi's equation, j'' = -K j), follow

       x'' = -D w A x,     j'' = -det(A) w j,     w = g^-2.

   The coefficients of their Taylor series follow from each other: those of g are sums of products of those of
   x, and from g w' = -2 g' w

       n g_0 w_n = - sum_{k=1..n} (n + k) g_k w_{n-k}.

   Each step is as long as the last coefficients allow.                                                   */
#include "geodesic.h"

#include "../../math/elementary.h"

#include <math.h>

#define ORDER 16 /* a power of 2, whose root is found by square roots */
#define LAST_TERM PRECISE(1e-17, 1e-9)
#define MOST_STEPS 64

typedef struct {
    real x[3][ORDER + 1], j[ORDER + 1], g[ORDER + 1], w[ORDER + 1];
} taylor;

static void expand_weight(const real square[3], int n, taylor *t)
{
    real g = 0, sum = 0;
    for (int i = 0; i < 3; i++) {
        real products = 0;
        for (int k = 0; 2 * k < n; k++) products += t->x[i][k] * t->x[i][n - k];
        products *= 2;
        if (n % 2 == 0) products += t->x[i][n / 2] * t->x[i][n / 2];
        g += square[i] * products;
    }
    t->g[n] = g;
    for (int k = 1; k <= n; k++) sum += (n + k) * t->g[k] * t->w[n - k];
    t->w[n] = n ? -sum / (n * t->g[0]) : 1 / (g * g);
}

static void expand_geodesic(const real A[3], const geodesic_point *p, taylor *t)
{
    const real square[3] = {A[0] * A[0], A[1] * A[1], A[2] * A[2]}, det = A[0] * A[1] * A[2];
    real along = 0, g = 0;
    for (int i = 0; i < 3; i++) {
        t->x[i][0] = p->x[i], t->x[i][1] = p->v[i];
        along += A[i] * p->v[i] * p->v[i], g += square[i] * p->x[i] * p->x[i];
    }
    const real D = along * g;
    t->j[0] = p->j, t->j[1] = p->dj;
    for (int n = 0; n + 2 <= ORDER; n++) {
        real x[3] = {0, 0, 0}, j = 0;
        expand_weight(square, n, t);
        for (int k = 0; k <= n; k++) {
            const real w = t->w[n - k];
            for (int i = 0; i < 3; i++) x[i] += w * t->x[i][k];
            j += w * t->j[k];
        }
        const real per = 1.0 / ((n + 1) * (n + 2));
        for (int i = 0; i < 3; i++) t->x[i][n + 2] = -D * A[i] * per * x[i];
        t->j[n + 2] = -det * per * j;
    }
}

static real longest_step(const taylor *t)
{
    real last = 0;
    for (int n = ORDER - 1; n <= ORDER; n++) {
        last += fabs(value_of(t->j[n]));
        for (int i = 0; i < 3; i++) last += fabs(value_of(t->x[i][n]));
    }
    real h = value_of(last) > 0 ? LAST_TERM / last : 1;
    for (int root = ORDER; root > 1; root /= 2) h = sqrt(h);
    return value_of(h);
}

static real sum_series(const real *coefficients, real h, real *slope)
{
    real sum = 0, rise = 0;
    for (int n = ORDER; n >= 0; n--) rise = rise * h + sum, sum = sum * h + coefficients[n];
    *slope = rise;
    return sum;
}

void geodesic_follow(const real half_axes[3], real way, geodesic_point *p)
{
    taylor t;
    real A[3], left = way;
    for (int i = 0; i < 3; i++) A[i] = 1 / (half_axes[i] * half_axes[i]);
    for (int step = 1;; step++) {
        expand_geodesic(A, p, &t);
        const real most = longest_step(&t);
        const int is_last = value_of(fabs(left)) <= value_of(most) || step == MOST_STEPS;
        const real h = is_last ? left : value_of(left) > 0 ? most : -most;
        for (int i = 0; i < 3; i++) p->x[i] = sum_series(t.x[i], h, p->v + i);
        p->j = sum_series(t.j, h, &p->dj);
        if (is_last) return;
        left -= h;
    }
}
