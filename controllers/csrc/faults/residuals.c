/* Residuals of the sensors in a tick.

   With z - h(q) = H d + noise for all lengths and encoders, d = C H'R^-1 (z - h(q)), C = (H'R^-1 H)^-1. The
   residual of sensor j against the fit of the others is r_j / (1 - h_j), with r = z - h(q) - H d and the leverage
   h_j = H_j C H_j' / R_j; its variance is R_j / (1 - h_j). A sensor that is not used in the fit has the residual r_j
   and the variance R_j + H_j C H_j'. */
#include "../../../sim_dart/csrc/math/cholesky.h"
#include "state.h"

#include <string.h>

static const real MIN_INDEPENDENT = (real)1e-4; /* 1 - h of a sensor that the others can verify */

/* Return the variance of a length or encoder, and its derivative by q in `row`; 0: not measured. `difference`:
   measured minus expected at q. */
static real sensor(const faults *s, size_t channel, const real **row, real *difference)
{
    if (channel < s->m) {
        const real noise = s->length_noise[channel];
        *row = s->jacobian + channel * s->n;
        *difference = s->lengths[channel] - s->path_lengths[channel];
        return faults_is_measured(noise) && faults_is_number(*difference) ? noise * noise : 0;
    }
    const size_t j = channel - 2 * s->m;
    const real noise = s->encoder_noise[j];
    memset(s->row, 0, s->n * sizeof(real));
    s->row[j] = 1;
    *row = s->row;
    *difference = s->encoders[j] - s->q[j];
    return faults_is_measured(noise) && faults_is_number(*difference) ? noise * noise : 0;
}

static void store(faults *s, size_t channel, real predicted, real residual, real weight)
{
    const size_t at = faults_at(s, channel, s->clock[0]);
    s->predicted[at] = predicted, s->residual[at] = residual, s->weight[at] = weight;
}

/* Add a sensor to the normal equations. */
static void accumulate(faults *s, const real *row, real difference, real variance)
{
    const size_t n = s->n;
    for (size_t j = 0; j < n; j++) {
        const real scaled = row[j] / variance;
        if (scaled == 0) continue;
        s->shift[j] += scaled * difference;
        for (size_t k = 0; k < n; k++) s->normal[j * n + k] += scaled * row[k];
    }
}

static size_t next_geometric(const faults *s, size_t channel)
{
    return channel + 1 == s->m ? 2 * s->m : channel + 1;
}

/* Fit all used sensors. Return 0, or 1 if they do not determine the coordinates. */
static int fit(faults *s)
{
    const size_t n = s->n;
    const real *row;
    real difference, variance;
    memset(s->normal, 0, n * n * sizeof(real));
    memset(s->shift, 0, n * sizeof(real));
    for (size_t i = 0; i < s->c; i = next_geometric(s, i))
        if (faults_is_used(s, i) && (variance = sensor(s, i, &row, &difference)) > 0)
            accumulate(s, row, difference, variance);
    if (cholesky_factor(n, s->normal, s->factor)) return 1;
    cholesky_solve(n, s->factor, s->shift);
    return 0;
}

/* Return whether geometry is linear up to the fit. A row of H that changes by its own size per unit of q has the error
   |H_j| d^2 / 2 of second order, and all rows together have trace(H'R^-1 H) d^4 / 4 squared standard deviations. In all
   ticks of a window, this error must not change its mean by more than one standard deviation; thresholds are about six. */
static int is_linear(const faults *s)
{
    const size_t n = s->n;
    const real square = cholesky_dot(n, s->shift, s->shift);
    real trace = 0;
    for (size_t j = 0; j < n; j++) trace += s->normal[j * n + j];
    return WINDOW * trace * square * square <= 4;
}

int faults_pose(faults *s)
{
    if (fit(s)) return FAULTS_POSE_UNKNOWN;
    if (is_linear(s)) return FAULTS_POSE_NEAR;
    for (size_t j = 0; j < s->n; j++) s->q[j] += s->shift[j];
    return FAULTS_POSE_FAR;
}

/* Return the standard deviation of the error of an encoder's prediction that the constant errors of the lengths cause.
   `solved`: column of C; with C without the sensor, it is larger by 1 / independent. */
static real error_by_lengths(const faults *s, const real *solved, real independent)
{
    real sum = 0;
    for (size_t i = 0; i < s->m; i++) {
        const real noise = s->length_noise[i], difference = s->lengths[i] - s->path_lengths[i];
        if (!faults_is_used(s, i) || !faults_is_measured(noise) || !faults_is_number(difference)) continue;
        const real effect = cholesky_dot(s->n, s->jacobian + i * s->n, solved) / (noise * noise) * s->length_error[i];
        sum += effect * effect;
    }
    return sqrt(sum) / independent;
}

/* Compute the covariance of the fit. */
static void find_spread(faults *s)
{
    const size_t n = s->n;
    memset(s->spread, 0, n * n * sizeof(real));
    for (size_t j = 0; j < n; j++) {
        s->spread[j * n + j] = 1;
        cholesky_solve(n, s->factor, s->spread + j * n);
    }
}

void faults_fit(faults *s)
{
    const size_t n = s->n;
    const real *row;
    real difference, variance;
    find_spread(s);
    for (size_t i = 0; i < s->c; i = next_geometric(s, i)) {
        variance = sensor(s, i, &row, &difference);
        if (variance == 0) {
            store(s, i, 0, 0, 0);
            continue;
        }
        for (size_t j = 0; j < n; j++) s->solved[j] = cholesky_dot(n, s->spread + j * n, row);
        const real spread = cholesky_dot(n, row, s->solved);
        real residual = difference - cholesky_dot(n, row, s->shift), weight = 1 / (variance + spread), independent = 1;
        if (faults_is_used(s, i)) {
            independent = 1 - spread / variance;
            residual /= independent;
            weight = independent > MIN_INDEPENDENT ? independent / variance : 0;
        }
        s->error[i] = i < s->m ? s->length_error[i] : weight > 0 ? error_by_lengths(s, s->solved, independent) : 0;
        const real measured = i < s->m ? s->lengths[i] : s->encoders[i - 2 * s->m];
        store(s, i, measured - residual, weight > 0 ? residual : 0, weight);
        faults_count(s, i, measured, variance);
    }
}

static real *sent(const faults *s, size_t i, real tick)
{
    return s->sent + (size_t)tick % WINDOW * s->m + i;
}

/* Return the force of a motor that is sent in this tick. */
static real limited_command(const faults *s, size_t i, real h)
{
    if (s->clock[0] == 0 || s->now[0] < s->start[0]) return s->commands[i];
    const real before = *sent(s, i, s->clock[0] - 1), change = h * s->force_rate[i];
    return smaller(larger(s->commands[i], before - change), before + change);
}

/* Update the tension expected from the commands. Return whether it can be compared. */
static int expect_tension(faults *s, size_t i, real h, real share)
{
    const real delayed = s->clock[0] - s->command_delay[0];
    *sent(s, i, s->clock[0]) = limited_command(s, i, h);
    if (delayed < 0) return 0;
    const real target = *sent(s, i, delayed);
    s->expected[i] = delayed > 0 ? s->expected[i] + share * (target - s->expected[i]) : target;
    return s->now[0] >= s->start[0] + s->command_delay[0] * h;
}

void faults_compare_tensions(faults *s, real h)
{
    const real share = s->motor_lag[0] > 0 ? 1 - exponential(-h / s->motor_lag[0]) : 1;
    for (size_t i = 0; i < s->m; i++) {
        const int is_expected = expect_tension(s, i, h, share);
        const real expected = s->expected[i], noise = s->tension_noise[i], error = s->tension_error[i] * expected;
        const real variance = noise * noise + error * error;
        const int is_measured = faults_is_number(s->tensions[i]) && variance > 0;
        const real residual = is_measured && is_expected ? s->tensions[i] - expected : 0;
        store(s, s->m + i, expected, residual, is_measured && is_expected ? 1 / variance : 0);
        if (is_measured) faults_count(s, s->m + i, s->tensions[i], variance);
    }
}
