/* A tick of the estimator: prediction, correction, validity. */
#include "../math/elementary.h"
#include "correct.h"
#include "horizon/horizon.h"
#include "measurements.h"
#include "predict.h"

static void take_tensions(estimator *e)
{
    for (size_t k = 0; k < e->m; k++) {
        const real last = e->last_tensions[k];
        if (is_number(e->tensions[k])) e->last_tensions[k] = larger(e->tensions[k], 0);
        e->changes[k] = e->last_tensions[k] - last;
    }
}

/* Compute standard deviations. Return 0, or 1 if a value is not finite or a variance is not positive. */
static int update_sd(estimator *e)
{
    const size_t N = e->N;
    int bad = 0;
    for (size_t k = 0; k < N; k++) {
        const real variance = e->covariance[k * N + k];
        bad |= !is_number(e->state[k]) || !(variance >= 0 && is_number(variance));
        e->sd[k] = variance > 0 ? sqrt(variance) : 0;
    }
    return bad;
}

/* Update the exponential average with time constant T: mean += (1 - exp(-h/T)) (now - mean). Without
   measurements for the time T the model cannot be verified, so that the estimate is not valid. */
static void update_validity(estimator *e, real time)
{
    e->blind[0] = e->seen ? 0 : e->blind[0] + time;
    if (e->seen) {
        const real share = 1 - exponential(-time / e->innovation_time[0]);
        e->mean_innovation[0] += share * (e->innovation[0] - e->mean_innovation[0]);
    }
    int valid = e->status[0] == ESTIMATOR_TRACKING;
    valid &= e->mean_innovation[0] <= e->largest_innovation[0] && e->blind[0] <= e->innovation_time[0];
    for (size_t j = 0; j < e->n; j++) valid &= e->sd[j] <= e->largest_sd[j];
    e->valid[0] = valid;
}

static int mark_lost(estimator *e)
{
    e->valid[0] = 0;
    return (int)(e->status[0] = ESTIMATOR_DIVERGED);
}

int estimator_tick(estimator *e, real h, int32_t steps)
{
    take_tensions(e);
    if (e->status[0] == ESTIMATOR_DIVERGED) return ESTIMATOR_DIVERGED;
    if (!estimator_is_tracking((int)e->status[0]) && e->search[0] != 0) {
        e->status[0] = (real)estimator_find(e);
        if (update_sd(e)) return mark_lost(e);
        if (e->status[0] == ESTIMATOR_TRACKING) update_validity(e, 0);
        return (int)e->status[0];
    }
    e->interval = h * (real)steps;
    if (most_exceed_gate(e)) /* velocities and loads are as uncertain as at the start */
        for (size_t k = e->n; k < 3 * e->n; k++) e->covariance[k * (e->N + 1)] += e->start_sd[k] * e->start_sd[k];
    horizon_begin(e, h, steps);
    for (int32_t k = 0; k < steps; k++)
        if (estimator_predict(e, h)) return mark_lost(e);
    horizon_append(e);
    estimator_begin(e);
    estimator_take_all(e);
    estimator_end(e);
    e->status[0] = (real)horizon_solve(e);
    if (e->status[0] == ESTIMATOR_DIVERGED || update_sd(e)) return mark_lost(e);
    update_validity(e, h * (real)steps);
    return (int)e->status[0];
}
