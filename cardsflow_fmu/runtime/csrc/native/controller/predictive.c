#include "predictive.h"

#include "../../../../../controllers/csrc/mpc/mpc.h"
#include "../../../../../sim_dart/csrc/tangent/shooting.h"
#include "../../platform/clock.h"
#include "../reference_parts.h"
#include "reacting.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char PREFIX[] = "mpc.";

struct predictive {
    mpc *law;
    void *law_memory, *core_memory, *shooting_memory;
    core_shooting *shooting;
    size_t n, m, a, r, N, part_count;
    const uint32_t *motors;
    int32_t *inputs;    /* of core_shooting_run: actuators, then states */
    int32_t *steps;     /* N: numbers of Runge-Kutta steps */
    double *controls;   /* N x (m + n): forces of muscles, generalised forces */
    double *lengths;    /* N: of these steps */
    double *difference; /* 3 r: of the input from the parts at the tick */
    double time;        /* of the reference of the tick */
    double rate;        /* of this time; 1 unless reactions slow the reference down */
    int is_slowed, has_fallen_back;
    struct native_robot *robot;
    void (*tasks)(void *, const double *, const double *, const double *, double *, double *, double *);
    const double *begins;
    reference_part *parts;
};

/* ------------------------------------------------------------------------------- functions of the law */

static int intervals(void *self, const double *h, const double *x, const double *forces, const double *load, double *ends,
                     double *derivatives)
{
    const struct predictive *p = self;
    for (size_t k = 0; k < p->N; k++) {
        p->lengths[k] = h[k] / p->steps[k];
        double *controls = p->controls + k * (p->m + p->n), *torques = controls + p->m;
        const double *f = forces + k * p->a;
        memcpy(controls, f, p->m * sizeof(double));
        for (size_t j = 0; j < p->n; j++) torques[j] = -load[j];
        for (size_t i = p->m; i < p->a; i++) torques[p->motors[i - p->m]] += f[i];
    }
    return core_shooting_run(p->shooting, (int32_t)p->N, p->steps, p->lengths, x, p->controls,
                             (int32_t)(p->a + 2 * p->n), p->inputs, ends, derivatives);
}

static void tasks(void *self, const double *q, const double *qd, const double *position, double *error, double *J,
                  double *bias)
{
    const struct predictive *p = self;
    p->tasks(p->robot, q, qd, position, error, J, bias);
}

/* Evaluate the parts at a time, with velocities and accelerations at the rate of the time. */
static void evaluate(const struct predictive *p, double then, double *reference)
{
    const size_t r = p->r;
    memset(reference, 0, 3 * r * sizeof(double));
    if (p->part_count)
        reference_evaluate(p->parts, p->begins, p->part_count, 1, &then, reference);
    for (size_t i = r; i < 3 * r && p->rate != 1; i++) reference[i] *= i < 2 * r ? p->rate : p->rate * p->rate;
}

/* Find the rate at which the reference `now` passes along the parts: the same path at another speed. */
static void find_rate(struct predictive *p, const double *now, double *reference)
{
    const size_t r = p->r;
    double along = 0, square = 0;
    p->rate = 1;
    evaluate(p, p->time, reference);
    for (size_t i = r; i < 2 * r; i++) along += now[i] * reference[i], square += reference[i] * reference[i];
    if (p->is_slowed && square > 0)
        p->rate = fmin(1, fmax(0, along / square));
}

/* Without parts, the velocity of the reference is constant; otherwise its difference from the parts is. */
static void preview(void *self, double ahead, const double *now, double *reference)
{
    struct predictive *p = self;
    const size_t r = p->r;
    if (ahead == 0)
        find_rate(p, now, reference);
    evaluate(p, p->time + p->rate * ahead, reference);
    for (size_t i = 0; i < 3 * r && ahead == 0; i++) p->difference[i] = now[i] - reference[i];
    for (size_t i = 0; i < r; i++) {
        reference[i] += p->difference[i] + ahead * p->difference[r + i];
        reference[r + i] += p->difference[r + i];
    }
}

static double seconds(void *self)
{
    (void)self;
    return monotonic_seconds();
}

static int solve(void *self, const double *q, const double *qd, const double *reference, const double *correction,
                 const double *load, double *forces, double *slack)
{
    struct predictive *p = self;
    const int status = mpc_solve(p->law, q, qd, reference, correction, load, forces, slack);
    p->has_fallen_back = status == COMPUTED_TORQUE_NEXT;
    return status;
}

/* ---------------------------------------------------------------------------- functions of the controller */

double *native_predictive_array(const struct controller *c, const char *name, size_t *length)
{
    const size_t skipped = sizeof PREFIX - 1;
    if (!c->predictive || strncmp(name, PREFIX, skipped))
        return NULL;
    return mpc_array(c->predictive->law, name + skipped, length);
}

double *native_predictive_memory(const struct controller *c, size_t *length)
{
    *length = 0;
    return c->predictive ? mpc_array(c->predictive->law, "planned", length) : c->last_position;
}

void native_predictive_reset(const struct controller *c)
{
    if (c->predictive)
        mpc_reset(c->predictive->law);
}

static void write_array(const struct controller *c, const char *name, const double *values, size_t count)
{
    size_t length;
    memcpy(mpc_array(c->predictive->law, name, &length), values, count * sizeof(double));
}

/* Write the limits of the actuators, within the bounds of the settings; the nearest to them if no force satisfies
   both. */
static void write_bounds(const struct controller *c, const char *min_name, const char *max_name, const double *f_min,
                         const double *f_max)
{
    mpc *law = c->predictive->law;
    size_t length;
    const double *low = mpc_array(law, "plan_min", &length), *high = mpc_array(law, "plan_max", &length);
    double *least = mpc_array(law, min_name, &length), *most = mpc_array(law, max_name, &length);
    for (size_t i = 0; i < c->a; i++) {
        least[i] = low[i] < f_min[i] ? f_min[i] : low[i] > f_max[i] ? f_max[i] : low[i];
        most[i] = high[i] > f_max[i] ? f_max[i] : high[i] < f_min[i] ? f_min[i] : high[i];
    }
}

void native_predictive_set(struct controller *c, double time, double period)
{
    struct predictive *p = c->predictive;
    if (!p)
        return;
    size_t length;
    const int looks_ahead = loop_array(c, "delay", &length)[0] != 0 && loop_array(c, "predict", &length)[0] != 0;
    p->is_slowed = c->reacting != NULL;
    p->time = p->is_slowed ? c->reached[0] : time;
    if (looks_ahead)
        p->time += p->is_slowed ? period * c->reaction[0] : period;
    write_array(c, "period", &period, 1);
    write_bounds(c, "f_min", "f_max", c->f_min, c->f_max);
    native_reacting_limit(c, mpc_array(p->law, "f_min", &length), mpc_array(p->law, "f_max", &length));
    write_bounds(c, "first_min", "first_max", c->in_loop.f_min, c->in_loop.f_max);
}

void native_predictive_report(const struct controller *c, double *report)
{
    size_t length;
    if (!c->predictive)
        return;
    report[0] = c->predictive->has_fallen_back;
    report[1] = mpc_array(c->predictive->law, "used", &length)[0];
    report[2] = mpc_array(c->predictive->law, "is_late", &length)[0];
}

void native_predictive_close(struct controller *c)
{
    struct predictive *p = c->predictive;
    if (!p)
        return;
    free(p->law_memory);
    free(p->core_memory);
    free(p->shooting_memory);
    free(p->inputs);
    free(p->controls);
    free(p->parts);
    free(p);
}

/* -------------------------------------------------------------------------------------------- opening */

/* Open the robot of the motions. Return nonzero if it is not valid. */
static int open_robot(struct predictive *p, const struct controller_settings *s)
{
    char message[256];
    const size_t bytes = s->of.plan_bytes.count, size = core_size(s->plan_robot, bytes, message, sizeof message);
    core *plain = size && (p->core_memory = malloc(size)) ? core_open(s->plan_robot, bytes, p->core_memory) : NULL;
    if (!plain)
        return 1;
    size_t n, m, states;
    core_array(plain, "q", &n), core_array(plain, "lengths", &m), core_array(plain, "law_states", &states);
    const size_t needed = core_shooting_size(plain);
    if (n != p->n || m != p->m || states || !needed || !(p->shooting_memory = malloc(needed)))
        return 1;
    p->shooting = core_shooting_open(plain, p->shooting_memory);
    return !p->shooting;
}

static int open_reference(struct predictive *p, const struct controller_settings *s)
{
    const struct native_parts parts = NATIVE_PARTS(s);
    p->part_count = parts.count;
    p->begins = parts.begin;
    p->parts = calloc(parts.count + 1, sizeof *p->parts);
    return !p->parts || (parts.count && native_parts_place(p->parts, &parts, p->r));
}

static int open_law(struct predictive *p, const struct controller *c)
{
    const size_t n = p->n, a = p->a, N = p->N;
    const mpc_model model = {p, intervals, tasks, preview, seconds};
    const size_t size = mpc_size((int)n, (int)a, (int)c->k, (int)N);
    p->inputs = calloc(a + 2 * n + N, sizeof *p->inputs);
    p->controls = calloc(N * (p->m + n + 1) + 3 * p->r, sizeof *p->controls);
    if (!size || !p->inputs || !p->controls || !(p->law_memory = malloc(size)))
        return 1;
    p->lengths = p->controls + N * (p->m + n);
    p->difference = p->lengths + N;
    for (size_t i = 0; i < a; i++)
        p->inputs[i] = (int32_t)(2 * n + (i < p->m ? i : p->m + p->motors[i - p->m]));
    for (size_t i = 0; i < 2 * n; i++) p->inputs[a + i] = (int32_t)i;
    p->steps = p->inputs + a + 2 * n;
    for (size_t k = 0; k < N; k++) p->steps[k] = (int32_t)c->settings.plan_steps[0];
    p->law = mpc_open(&model, (int)n, (int)a, (int)c->k, (int)N, p->law_memory);
    return !p->law;
}

int native_predictive_open(struct controller *c, struct native_model *native,
                           void (*tasks_of_loop)(void *, const double *, const double *, const double *, double *,
                                                 double *, double *),
                           struct text *error)
{
    const struct controller_settings *s = &c->settings;
    if (!s->nodes[0])
        return 0;
    struct predictive *p = c->predictive = calloc(1, sizeof *p);
    if (!p || s->nodes[0] > 4096) {
        text_set(error, "not enough memory for the controller");
        return 1;
    }
    p->n = native->robot.n, p->m = native->robot.m, p->a = c->a, p->r = c->r, p->N = s->nodes[0];
    p->robot = &native->robot, p->motors = s->motors, p->tasks = tasks_of_loop;
    if (open_robot(p, s) || open_reference(p, s) || open_law(p, c)) {
        text_set(error, "native.bin does not match its controller, or this platform does not support derivatives");
        return 1;
    }
    const control_law law = {p, NULL, solve, NULL};
    size_t length;
    control_loop_set_law(c->loop, &law);
    loop_array(c, "midpoint", &length)[0] = 1;
    return 0;
}
