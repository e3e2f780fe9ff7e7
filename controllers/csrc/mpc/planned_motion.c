#include "planned_motion.h"

#include <string.h>

void planned_motion_divide(mpc *s)
{
    const real h = (s->horizon[0] - s->period[0]) / (real)(s->N - 1);
    for (size_t k = 0; k < s->N; k++) s->h[k] = k ? h : s->period[0];
}

void planned_motion_rest(mpc *s, const real *q)
{
    for (size_t k = 0; k <= s->N; k++) {
        memcpy(s->x + k * 2 * s->n, q, s->n * sizeof(real));
        memset(s->x + (k * 2 + 1) * s->n, 0, s->n * sizeof(real));
    }
    for (size_t k = 0; k < s->N; k++) memcpy(s->f + k * s->a, s->f_p, s->a * sizeof(real));
}

void planned_motion_shift(mpc *s)
{
    const size_t n = 2 * s->n, a = s->a, N = s->N;
    for (size_t k = 0; k < N; k++) {
        const real part = smaller(s->h[0] / s->h[k], 1);
        real *x = s->x + k * n, *f = s->f + k * a;
        for (size_t j = 0; j < n; j++) x[j] += part * (x[n + j] - x[j]);
        for (size_t i = 0; i < a && k + 1 < N; i++) f[i] += part * (f[a + i] - f[i]);
    }
    for (size_t j = 0; j < s->n; j++) s->x[N * n + j] += s->h[0] * s->x[N * n + s->n + j];
}

void planned_motion_clip(mpc *s)
{
    const size_t a = s->a;
    for (size_t i = 0; i < s->N * a; i++) {
        const real *low = i < a ? s->first_min : s->f_min, *high = i < a ? s->first_max : s->f_max;
        s->f[i] = clip(s->f[i], low[i % a], high[i % a]);
    }
}

void planned_motion_add(mpc *s)
{
    const size_t n = 2 * s->n, a = s->a, w = a + n;
    for (size_t k = 0; k <= s->N; k++) {
        if (k < s->N) add(a, s->f + k * a, 1, s->qp.v + k * w);
        add(n, s->x + k * n, 1, s->qp.v + mpc_states(s, k));
    }
}
