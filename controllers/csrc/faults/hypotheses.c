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
static const real MEAN_WEAKNESS = (real)-0.5, WEAKNESS = (real)0.3;

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

/* Return the variance of a tension that is really there. */
static real tension_variance(const faults *s, size_t muscle, real tension)
{
    const real error = s->tension_error[muscle] * tension, noise = s->tension_noise[muscle];
    return noise * noise + error * error;
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
