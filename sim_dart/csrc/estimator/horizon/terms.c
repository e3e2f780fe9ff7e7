#include "terms.h"

#include "../../numbers/real_functions.h"

#include <string.h>

static const real BOUND_VARIANCE = PRECISE(1e-12, 1e-8); /* of q at a bound, so that programs are regular */

/* Append a term with bounds of its multiplier to the current frame. */
static void add_term(estimator *e, size_t slot, const real *row, size_t width, real residual, real variance,
                     real least, real most)
{
    horizon *h = e->horizon;
    const size_t k = (size_t)(e->is_collecting - 1), wide = 3 * e->n, t = k * h->T + (size_t)h->count[k];
    h->count[k] += 1;
    h->slot[t] = (real)slot, h->residual[t] = residual, h->variance[t] = variance;
    h->least[t] = least, h->most[t] = most;
    memset(h->row + t * wide, 0, wide * sizeof(real));
    memcpy(h->row + t * wide, row, width * sizeof(real));
    h->spread[t] = variance;
}

void horizon_add(estimator *e, size_t slot, const real *row, size_t width, real residual, real variance)
{
    const horizon *h = e->horizon;
    const real most = h->huber[0] > 0 ? h->huber[0] / sqrt(variance) : INFINITY;
    add_term(e, slot, row, width, residual, variance, -most, slot < e->m && !is_taut(e, slot) ? 0 : most);
}

void horizon_add_bounds(estimator *e)
{
    const horizon *h = e->horizon;
    const size_t n = e->n;
    for (size_t j = 0; j < n; j++) {
        memset(e->row, 0, n * sizeof(real));
        e->row[j] = 1;
        if (is_number(h->low[j]))
            add_term(e, h->B + 2 * j, e->row, n, h->low[j] - e->state[j], BOUND_VARIANCE, 0, INFINITY);
        if (is_number(h->high[j]))
            add_term(e, h->B + 2 * j + 1, e->row, n, h->high[j] - e->state[j], BOUND_VARIANCE, -INFINITY, 0);
    }
}
