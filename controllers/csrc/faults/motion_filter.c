/* Kalman filters of the motion. */
#include "motion_filter.h"

#include "../../../sim_dart/csrc/math/cholesky.h"

#include <string.h>

motion_record motion_at(const faults *s, real tick)
{
    const size_t n = s->n, m = s->m, at = (size_t)tick % MOTION_WINDOW;
    const motion_record record = {
        s->motion_gain + at * 3 * n * n, s->motion_mobility + at * n * n, s->motion_factor + at * n * n,
        s->motion_white + at * n,        s->motion_forces + at * m,       s->motion_lengths + at * m,
        s->motion_jacobian + at * m * n, s->motion_agile + at};
    return record;
}

int motion_decompose(size_t n, const real *A, real *factor)
{
    if (cholesky_factor(n, A, factor)) return 1;
    for (size_t i = 0; i < n; i++) factor[i * n + i] = 1 / factor[i * n + i];
    return 0;
}

void motion_whiten(size_t n, const real *factor, real *x)
{
    for (size_t i = 0; i < n; i++) x[i] = (x[i] - cholesky_dot(i, factor + i * n, x)) * factor[i * n + i];
}

void motion_advance(const faults *s, const real *W, real h, real *x)
{
    const size_t n = s->n;
    real *v = x + n;
    const real *w = v + n;
    for (size_t j = 0; j < n; j++) {
        const real change = -h * cholesky_dot(n, W + j * n, w);
        x[j] += h * (v[j] + s->substeps[0] * change);
        v[j] += change;
    }
}

void motion_add_gain(size_t n, const real *gain, const real *white, real sign, real *x)
{
    for (size_t j = 0; j < 3 * n; j++) x[j] += sign * cholesky_dot(n, gain + j * n, white);
}

void faults_forget_motion(faults *s)
{
    s->motion_begin[0] = s->followed[0] = -1;
}

/* Return the maximum factor of the variance of the drift: the geometric mean of 1 and of the factor with which loads drift
   as in the second filter, by `load_change` in a window. Larger changes are not followed, but detected. */
static real max_agility(const faults *s)
{
    const size_t n = s->n;
    const real slow = WINDOW * s->step * cholesky_dot(n, s->load_noise, s->load_noise);
    return slow > 0 ? larger(sqrt(cholesky_dot(n, s->load_change, s->load_change) / slow), 1) : 1;
}

void faults_accept_load(faults *s, int is_change)
{
    if (is_change) s->loaded[0] = 1;
    const size_t N = 3 * s->n;
    memcpy(s->motion_state, s->motion_state + N, N * sizeof(real));
    memcpy(s->motion_covariance, s->motion_covariance + N * N, N * N * sizeof(real));
    s->motion_begin[0] = s->clock[0];
    s->followed[0] = -1;
    s->agility[0] = max_agility(s);
}

/* Adapt the drift to the innovations before a change (Mehra 1970): a payload or a contact moves with the robot. An
   innovation beyond the threshold is a change. */
static void adapt(faults *s, const real *white)
{
    const real square = smaller(cholesky_dot(s->n, white, white), 2 * s->limit);
    const real agility = s->agility[0] * exponential((square / (real)s->n - 1) / MOTION_WINDOW);
    s->agility[0] = smaller(larger(agility, 1), max_agility(s));
}

/* Begin again at the fit, with unknown velocities and loads. */
static void begin(faults *s, real h)
{
    const size_t n = s->n, N = 3 * n;
    const real rate = WINDOW / h;
    real *x = s->motion_state + N, *P = s->motion_covariance + N * N;
    memset(P, 0, N * N * sizeof(real));
    for (size_t j = 0; j < n; j++) {
        const real variance = s->spread[j * n + j], load = s->load_change[j];
        x[j] = s->q[j] + s->shift[j];
        x[n + j] = s->velocity[j], x[2 * n + j] = s->load[j];
        P[j * N + j] = variance;
        P[(n + j) * N + n + j] = variance * rate * rate;
        P[(2 * n + j) * N + 2 * n + j] = load * load;
    }
    memcpy(s->motion_force, s->acting, s->m * sizeof(real));
    faults_accept_load(s, 0);
    s->agility[0] = 1;
}

/* Compute P <- A P A' + Q. */
static void predict_covariance(const faults *s, const real *drift, real factor, real h, real *P)
{
    const size_t n = s->n, N = 3 * n;
    for (size_t j = 0; j < N; j++) motion_advance(s, s->mobility, h, P + j * N);
    for (size_t j = 0; j < 2 * n; j++) {
        for (size_t k = 0; k < j; k++) {
            const real value = P[j * N + k];
            P[j * N + k] = P[k * N + j], P[k * N + j] = value;
        }
        for (size_t k = 2 * n; k < N; k++) P[j * N + k] = P[k * N + j]; /* the loads do not change */
    }
    for (size_t j = 0; j < 2 * n; j++) motion_advance(s, s->mobility, h, P + j * N);
    for (size_t j = 0; j < n; j++) P[(2 * n + j) * (N + 1)] += drift[j] * drift[j] * h * factor;
}

/* Compute the change of velocities by the model, with the forces after the lag of the motors: the model has used
   commands. Store the mean forces. */
static void find_change(faults *s, const motion_record *now, real h, real *change)
{
    const size_t n = s->n;
    const real lag = s->motor_lag[0], share = lag > 0 ? 1 - exponential(-h / lag) : 1;
    real *load = s->solved;
    memset(load, 0, n * sizeof(real));
    for (size_t i = 0; i < s->m; i++) {
        const real rest = lag > 0 ? s->acting[i] - s->motion_force[i] : 0, missing = rest * share * lag / h;
        s->motion_force[i] = s->acting[i] - rest * (1 - share);
        now->forces[i] = s->acting[i] - missing;
        for (size_t j = 0; j < n; j++) load[j] += missing * s->jacobian[i * n + j];
    }
    for (size_t j = 0; j < n; j++)
        change[j] = h * (s->acceleration[j] + cholesky_dot(n, s->mobility + j * n, load));
}

static void predict_state(const faults *s, const real *change, real h, real *x)
{
    motion_advance(s, s->mobility, h, x);
    for (size_t j = 0; j < s->n; j++) {
        x[j] += h * s->substeps[0] * change[j];
        x[s->n + j] += change[j];
    }
}

/* Correct by the fit of this tick. Return 0, or 1 if the covariance is not positive definite. */
static int correct(faults *s, real *x, real *P, const motion_record *now)
{
    const size_t n = s->n, N = 3 * n;
    for (size_t j = 0; j < n; j++) {
        for (size_t k = 0; k < n; k++) s->matrix[j * n + k] = P[j * N + k] + s->spread[j * n + k];
        now->white[j] = s->q[j] + s->shift[j] - x[j];
    }
    if (motion_decompose(n, s->matrix, now->factor)) return 1;
    motion_whiten(n, now->factor, now->white);
    for (size_t j = 0; j < N; j++) {
        memcpy(now->gain + j * n, P + j * N, n * sizeof(real));
        motion_whiten(n, now->factor, now->gain + j * n);
    }
    motion_add_gain(n, now->gain, now->white, 1, x);
    for (size_t j = 0; j < N; j++)
        for (size_t k = 0; k <= j; k++)
            P[j * N + k] = P[k * N + j] -= cholesky_dot(n, now->gain + j * n, now->gain + k * n);
    return 0;
}

/* Return the log ratio of the densities of two innovations. */
static real log_density_ratio(size_t n, const motion_record *a, const motion_record *b)
{
    real ratio = 1;
    for (size_t j = 0; j < n; j++) ratio *= a->factor[j * n + j] / b->factor[j * n + j];
    return logarithm(ratio) + (cholesky_dot(n, b->white, b->white) - cholesky_dot(n, a->white, a->white)) / 2;
}

int motion_filter(faults *s, real h, int steps, int is_fit)
{
    const size_t n = s->n, N = 3 * n;
    const real now = s->clock[0], window = WINDOW * h;
    real *x = s->motion_state, *P = s->motion_covariance;
    s->substeps[0] = steps > 0 ? (1 + 1 / (real)steps) / 2 : 1;
    const int is_new = s->motion_begin[0] < 0 || s->motion_tick[0] != now - 1 || steps < 1;
    s->motion_tick[0] = now;
    if (is_new) {
        if (is_fit) begin(s, h);
        return 0;
    }
    const motion_record record = motion_at(s, now);
    motion_record agile = record;
    agile.gain = s->agile_gain, agile.factor = s->agile_factor, agile.white = s->agile_white;
    memcpy(record.mobility, s->mobility, n * n * sizeof(real));
    memcpy(record.lengths, s->path_lengths, s->m * sizeof(real));
    for (size_t i = 0; i < s->m && is_fit; i++) record.lengths[i] += cholesky_dot(n, s->jacobian + i * n, s->shift);
    memcpy(record.jacobian, s->jacobian, s->m * n * sizeof(real));
    find_change(s, &record, h, s->signal);
    record.factor[0] = *record.agile = 0;
    for (size_t k = 0; k < 2; k++) {
        predict_state(s, s->signal, h, x + k * N);
        predict_covariance(s, k ? s->load_change : s->load_noise, k ? 1 / window : s->agility[0], h, P + k * N * N);
        if (is_fit && correct(s, x + k * N, P + k * N * N, k ? &agile : &record)) {
            faults_forget_motion(s);
            return 0;
        }
    }
    if (!is_fit) return 1;
    *record.agile = log_density_ratio(n, &agile, &record);
    if (s->followed[0] < 0) adapt(s, record.white);
    return 1;
}
