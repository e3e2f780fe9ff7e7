#include "policy.h"

#include "../../../../../../sim_dart/csrc/math/elementary.h"

#include <math.h>
#include <string.h>

static const double MAX_COUNT = 1e6;

/* Numbers that are still to be read. */
typedef struct {
    const double *next, *end;
} source;

static const double *take(source *from, size_t count)
{
    const double *at = from->next;
    if (!at || count > (size_t)(from->end - at)) return from->next = NULL;
    from->next = at + count;
    return at;
}

/* Return a count; 0 and an invalid source if the number is not a positive whole number. */
static size_t take_count(source *from, double least)
{
    const double *at = take(from, 1);
    if (at && *at >= least && *at <= MAX_COUNT && *at == floor(*at)) return (size_t)*at;
    from->next = NULL;
    return 0;
}

static int are_below(const double *values, size_t count, double limit)
{
    for (size_t i = 0; values && i < count; i++)
        if (!(values[i] >= 0 && values[i] < limit && values[i] == floor(values[i]))) return 0;
    return values != NULL;
}

/* Check the layers, and find the widest one. */
static int read_layers(policy *p, source *from)
{
    size_t before = p->inputs;
    p->network = from->next, p->width = p->inputs;
    for (size_t k = 0; k < p->layers && from->next; k++) {
        const size_t rows = take_count(from, 1), columns = take_count(from, 1);
        const double *kind = take(from, 1);
        if (!are_below(kind, 1, POLICY_ACTIVATIONS_END) || columns != before) return 1;
        take(from, rows * columns + rows);
        before = rows;
        if (rows > p->width) p->width = rows;
    }
    return before != p->outputs;
}

int policy_open(policy *p, const double *numbers, size_t count)
{
    source from = {numbers, numbers + count};
    memset(p, 0, sizeof *p);
    p->inputs = take_count(&from, 1), p->outputs = take_count(&from, 1), p->layers = take_count(&from, 1);
    p->parts = take_count(&from, 1), p->activations = take_count(&from, 0);
    const double *settings = take(&from, 3);
    p->part = take(&from, p->parts), p->activation = take(&from, p->activations);
    p->target = take(&from, 2 * p->outputs), p->mean = take(&from, p->inputs), p->scale = take(&from, p->inputs);
    if (!settings || !are_below(p->part, p->parts, POLICY_PARTS)) return 1;
    p->step = settings[0], p->max_input = settings[1], p->is_sigmoid = settings[2] != 0;
    if (!(p->step > 0) || !(p->max_input > 0) || read_layers(p, &from)) return 1;
    p->low = take(&from, p->outputs), p->high = take(&from, p->outputs), p->fallback = take(&from, p->outputs);
    return !from.next || from.next != from.end;
}

static double activate(double x, double kind)
{
    switch ((int)kind) {
    case POLICY_TANH: return x > 20 ? 1 : x < -20 ? -1 : 1 - 2 / (exponential(2 * x) + 1);
    case POLICY_RELU: return x > 0 ? x : 0;
    case POLICY_ELU: return x > 0 ? x : exponential(x) - 1;
    case POLICY_SIGMOID: return 1 / (1 + exponential(-x));
    default: return x;
    }
}

static double limited(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* Return the command for an action from -1 to 1. */
static double command(const policy *p, size_t i, double action)
{
    const double a = limited(action, -1, 1);
    const int is_muscle = p->target[2 * i] != 0;
    const double value = p->is_sigmoid && is_muscle ? 1 / (1 + exponential(-5 * (a - 0.5)))
                                                    : p->low[i] + 0.5 * (1 + a) * (p->high[i] - p->low[i]);
    return limited(value, p->low[i], p->high[i]);
}

int policy_evaluate(const policy *p, const double *inputs, double *scratch, double *outputs)
{
    double *x = scratch, *y = scratch + p->width;
    int is_sound = 1;
    for (size_t i = 0; i < p->inputs; i++) {
        x[i] = (inputs[i] - p->mean[i]) * p->scale[i];
        is_sound &= x[i] <= p->max_input && x[i] >= -p->max_input; /* false for NaN */
    }
    const double *layer = p->network;
    for (size_t k = 0; k < p->layers && is_sound; k++) {
        const size_t rows = (size_t)layer[0], columns = (size_t)layer[1];
        const double *weights = layer + 3, *bias = weights + rows * columns;
        for (size_t i = 0; i < rows; i++) {
            double sum = bias[i];
            for (size_t j = 0; j < columns; j++) sum += weights[i * columns + j] * x[j];
            y[i] = activate(sum, layer[2]);
        }
        double *swap = x;
        x = y, y = swap, layer = bias + rows;
    }
    for (size_t i = 0; i < p->outputs; i++) is_sound &= isfinite(x[i]) != 0;
    for (size_t i = 0; i < p->outputs; i++) outputs[i] = is_sound ? command(p, i, x[i]) : p->fallback[i];
    return !is_sound;
}
