#include "measurements.h"

#include "correct.h"
#include "inertial.h"

#include <string.h>

/* The filter ignores slack muscles; the horizon uses their lengths as bounds of l(q). */
static void take_lengths(estimator *e)
{
    const core *c = e->core;
    for (size_t k = 0; k < e->m; k++)
        if (is_taut(e, k) || (e->is_collecting && has_length(e, k)))
            estimator_take(e, e->lengths + k, c->jacobian + k * e->n, e->n, offset_state(e, k),
                           path_length(e, k) - c->lengths[k], e->length_noise[k] * e->length_noise[k]);
}

static void take_encoders(estimator *e)
{
    for (size_t j = 0; j < e->n; j++) {
        if (!is_measured(e->encoder_noise[j]) || !is_number(e->encoders[j])) continue;
        memset(e->row, 0, e->n * sizeof(real));
        e->row[j] = 1;
        estimator_take(e, e->encoders + j, e->row, e->n, e->N, e->encoders[j] - e->state[j],
                       e->encoder_noise[j] * e->encoder_noise[j]);
    }
}

void estimator_take_all(estimator *e)
{
    take_lengths(e);
    take_encoders(e);
    estimator_take_inertial(e);
}
