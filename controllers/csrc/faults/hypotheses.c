/* Bayes factors of hypotheses about one channel.

   A hypothesis with residual r_t = a x_t + noise of variance 1 / w_t and the prior a ~ N(a_0, s^2) has the Bayes factor

     log B = d - log(1 + s^2 I) / 2,  d = (S + a_0 / s^2)^2 / (2 (I + 1/s^2)) - a_0^2 / (2 s^2),
     S = sum w x r,  I = sum w x^2

   against r_t = noise. Priors have the sizes of such faults, so that hypotheses with and without parameters can
   be compared. */
#include "hypotheses.h"

static const real IMPOSSIBLE = -(real)1e9;
static const real BIAS = (real)0.02;         /* [m] or [rad] */
static const real SCALE = (real)0.5;
static const real SCALE_START = (real)0.0005; /* deviation when the window begins, in [m] */
static const real STIFFNESS = 30000;         /* [N/m] */
static const real MEAN_WEAKNESS = (real)-0.5, WEAKNESS = (real)0.3, MIN_WEAKNESS = (real)0.1;
static const real FIRST = (real)0.5, FIRST_SD = (real)0.3; /* share of the first tick before a fault */

/* Sums of a regression. */
typedef struct {
    real S, I;
} sums;

static fault_fit evaluate(sums sum, real mean, real sd)
{
    const real prior = 1 / (sd * sd), shifted = sum.S + mean * prior;
    fault_fit fit;
    fit.value = shifted / (sum.I + prior);
    fit.factor = shifted * fit.value / 2 - mean * mean * prior / 2 - logarithm(1 + sum.I / prior) / 2;
    return fit;
}

fault_fit faults_fit_bias(const faults *s, size_t i, real begin)
{
    sums sum = {0, 0};
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        sum.S += s->weight[at] * s->residual[at], sum.I += s->weight[at];
    }
    return evaluate(sum, 0, BIAS);
}

/* Sums of a regression r = c + a x. */
typedef struct {
    real base, w, wx, wxx, wr, wxr;
} line_sums;

static void add_to_line(line_sums *sum, real w, real x, real r)
{
    sum->w += w, sum->wx += w * x, sum->wxx += w * x * x, sum->wr += w * r, sum->wxr += w * x * r;
}

/* The same with two parameters, whose priors have the mean 0; `value` is the slope a. */
static fault_fit evaluate_line(line_sums sum, real sd_c, real sd_a)
{
    const real p = 1 / (sd_c * sd_c), q = 1 / (sd_a * sd_a), a = sum.w + p, b = sum.wx, c = sum.wxx + q;
    const real determinant = a * c - b * b;
    const real y = (c * sum.wr - b * sum.wxr) / determinant, z = (a * sum.wxr - b * sum.wr) / determinant;
    const fault_fit fit = {sum.base + (sum.wr * y + sum.wxr * z) / 2 - logarithm(determinant / (p * q)) / 2, z};
    return fit;
}

/* r = c + (scale - 1) (l - l_begin), with a small c, since the fault may be older than the window. */
fault_fit faults_fit_scale(const faults *s, size_t i, real begin)
{
    line_sums sum = {0, 0, 0, 0, 0, 0};
    const real first = s->predicted[faults_at(s, i, begin)];
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        add_to_line(&sum, s->weight[at], s->predicted[at] - first, s->residual[at]);
    }
    fault_fit fit = evaluate_line(sum, SCALE_START, SCALE);
    fit.value += 1;
    return fit;
}

/* Return whether all values since `begin` are equal. */
static int is_constant(const faults *s, size_t i, real begin)
{
    return s->run[i] >= s->clock[0] - begin;
}

/* The first value is healthy; the others are equal to it. */
fault_fit faults_fit_stuck(const faults *s, size_t i, real begin)
{
    fault_fit fit = {is_constant(s, i, begin) ? s->evidence[i] : IMPOSSIBLE, 0};
    for (real t = begin + 1; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        fit.factor += s->weight[at] * s->residual[at] * s->residual[at] / 2;
    }
    return fit;
}

/* r = c - (l - l_begin), with a small c. */
fault_fit faults_fit_hold(const faults *s, size_t i, real begin)
{
    const real first = s->predicted[faults_at(s, i, begin)];
    real base = 0;
    sums sum = {0, 0};
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        const real r = s->residual[at], rest = r + s->predicted[at] - first;
        base += s->weight[at] * (r * r - rest * rest) / 2;
        sum.S += s->weight[at] * rest, sum.I += s->weight[at];
    }
    fault_fit fit = evaluate(sum, 0, SCALE_START);
    fit.factor += base;
    return fit;
}

/* z = a y_0 + b y_3; b: the fault begins within the first tick. A share from MIN_WEAKNESS to 1 is lost. */
fault_fit faults_fit_weakness(const real S[SIGNS], const real I[SIGNS * SIGNS])
{
    const real a = MEAN_WEAKNESS, b = -MEAN_WEAKNESS * FIRST;
    const real base = a * S[0] + b * S[3] - (a * a * I[0] + 2 * a * b * I[3] + b * b * I[15]) / 2;
    const line_sums sum = {base, I[15], I[3], I[0], S[3] - a * I[3] - b * I[15], S[0] - a * I[0] - b * I[3]};
    fault_fit fit = evaluate_line(sum, FIRST_SD, WEAKNESS);
    const real lost = -fit.value - a, nearest = larger(smaller(lost, 1), MIN_WEAKNESS), off = nearest - lost;
    const real info = I[0] - I[3] * I[3] / (I[15] + 1 / (FIRST_SD * FIRST_SD)) + 1 / (WEAKNESS * WEAKNESS);
    fit.factor -= off * off * info / 2;
    fit.value = 1 - nearest;
    return fit;
}

/* z = -y_0 + b y_3. */
fault_fit faults_fit_break(const real S[SIGNS], const real I[SIGNS * SIGNS])
{
    const sums sum = {S[3] + I[3], I[15]};
    fault_fit fit = evaluate(sum, FIRST, FIRST_SD);
    fit.factor -= S[0] + I[0] / 2;
    fit.value = 0;
    return fit;
}

/* Return the variance of a tension that is really there. */
static real tension_variance(const faults *s, size_t muscle, real tension)
{
    const real error = s->tension_error[muscle] * tension, noise = s->tension_noise[muscle];
    return noise * noise + error * error;
}

/* z = -y_0 + (force + c) y_1 + k y_2, with a small c, since the begin is not exact. */
fault_fit faults_fit_spring(const faults *s, size_t i, const real S[SIGNS], const real I[SIGNS * SIGNS], real force)
{
    const real base = -(I[0] + force * force * I[5]) / 2 - S[0] + force * (S[1] + I[1]);
    const line_sums sum = {base, I[5], I[6], I[10], S[1] + I[1] - force * I[5], S[2] + I[2] - force * I[6]};
    fault_fit fit = evaluate_line(sum, sqrt(tension_variance(s, i, force)), STIFFNESS);
    if (fit.value < 0) fit.factor = IMPOSSIBLE;
    return fit;
}

fault_fit faults_fit_swap(const faults *s, size_t i, size_t other, real begin)
{
    fault_fit fit = {0, 0};
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        const real rest = s->residual[at] + s->predicted[at] - s->predicted[faults_at(s, other, t)];
        fit.factor += s->weight[at] * (s->residual[at] * s->residual[at] - rest * rest) / 2;
    }
    return fit;
}

fault_fit faults_fit_dead(const faults *s, size_t i, real begin)
{
    const size_t muscle = i - s->m;
    fault_fit fit = {is_constant(s, i, begin) ? s->evidence[i] : 0, 0};
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        const real r = s->residual[at], measured = s->predicted[at] + r;
        fit.factor += (s->weight[at] * r * r - measured * measured / tension_variance(s, muscle, 0)) / 2;
    }
    return fit;
}

/* measured = (1 + a) command, with the variance of the measured tension. */
fault_fit faults_fit_weak(const faults *s, size_t i, real begin)
{
    sums sum = {0, 0};
    real base = 0;
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        const real r = s->residual[at], x = s->predicted[at], w = 1 / tension_variance(s, i - s->m, x + r);
        base += (s->weight[at] - w) * r * r / 2;
        sum.S += w * x * r, sum.I += w * x * x;
    }
    fault_fit fit = evaluate(sum, MEAN_WEAKNESS, WEAKNESS);
    fit.factor += base, fit.value += 1;
    return fit;
}

/* measured = force at the begin + c + stiffness (l - l_begin), with a small c, since the begin is not exact. */
fault_fit faults_fit_jam(const faults *s, size_t i, real begin)
{
    const size_t muscle = i - s->m;
    const real before = larger(begin - 1, 0);
    const real force = s->predicted[faults_at(s, i, before)], length = s->predicted[faults_at(s, muscle, before)];
    line_sums sum = {0, 0, 0, 0, 0, 0};
    for (real t = begin; t <= s->clock[0]; t++) {
        const size_t at = faults_at(s, i, t);
        const real r = s->residual[at], measured = s->predicted[at] + r, rest = measured - force;
        const real w = 1 / tension_variance(s, muscle, measured);
        sum.base += (s->weight[at] * r * r - w * rest * rest) / 2;
        add_to_line(&sum, w, s->predicted[faults_at(s, muscle, t)] - length, rest);
    }
    return evaluate_line(sum, sqrt(tension_variance(s, muscle, force)), STIFFNESS);
}
