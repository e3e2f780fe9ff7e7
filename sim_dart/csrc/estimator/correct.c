/* Scalar measurements: k = P H', S = H k + r, x <- x + k nu / S, P <- P - k k' / S. */
#include "correct.h"

#include "../numbers/real_functions.h"
#include "horizon/terms.h"

#include <string.h>

void estimator_begin(estimator *e)
{
    memset(e->shift, 0, e->N * sizeof(real));
    e->seen = e->taken = 0, e->squares = 0;
}

/* Compute k <- k + factor * row j of P. */
static void add_row(const estimator *e, size_t j, real factor)
{
    const size_t N = e->N;
    const real *from = e->covariance + j * N;
    for (size_t l = 0; l < N; l++) e->gain[l] += factor * from[l];
}

/* Process one measurement, unless it exceeds the gate, and most measurements of the last tick did not. */
static void correct(estimator *e, const real *row, size_t width, size_t bias, real residual, real variance)
{
    const size_t N = e->N;
    real *k = e->gain, *P = e->covariance, S = variance;
    memset(k, 0, N * sizeof(real));
    for (size_t j = 0; j < width; j++) {
        if (row[j] == 0) continue;
        add_row(e, j, row[j]);
        residual -= row[j] * e->shift[j];
    }
    if (bias < N) {
        add_row(e, bias, 1);
        residual -= e->shift[bias];
        S += k[bias];
    }
    for (size_t j = 0; j < width; j++) S += row[j] * k[j];
    const real square = residual * residual / S, limit = e->gate[0] * e->gate[0];
    e->seen++;
    e->squares += square < limit ? square : limit;
    if (!(square <= limit) && !most_exceed_gate(e)) return;
    e->taken++;
    const real root = 1 / sqrt(S), step = residual / S;
    for (size_t l = 0; l < N; l++) e->shift[l] += step * k[l], k[l] *= root;
    for (size_t j = 0; j < N; j++)
        for (size_t l = 0; l < N; l++) P[j * N + l] -= k[j] * k[l];
}

void estimator_take(estimator *e, const real *z, const real *row, size_t width, size_t bias, real residual,
                    real variance)
{
    if (e->is_collecting)
        horizon_add(e, (size_t)(z - e->lengths), row, width, residual, variance);
    else
        correct(e, row, width, bias, residual, variance);
}

void estimator_end(estimator *e)
{
    for (size_t l = 0; l < e->N; l++) e->state[l] += e->shift[l];
    e->used[0] = (real)e->taken;
    e->innovation[0] = e->seen ? e->squares / (real)e->seen : 0;
}
