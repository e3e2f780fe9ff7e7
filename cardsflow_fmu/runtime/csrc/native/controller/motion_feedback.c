#include "state.h"

#include "../../../../../controllers/csrc/laws/held_motion.h"

#include <stdlib.h>
#include <string.h>

enum { FEEDFORWARD = 1, BY_FORCES, BY_COMMANDS };

struct motion_feedback {
    struct controller *c;
    held_motion motion;
    double time, *u, *extra, *deviation, *commands;
    size_t n, m;
};

static double clip_to(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

/* Compute u of a tick. */
static void compute_controls(struct motion_feedback *p, const double *q, const double *qd, const double *reference)
{
    const size_t n = p->n;
    for (size_t j = 0; j < n; j++) {
        p->deviation[j] = reference[j] - q[j];
        p->deviation[n + j] = reference[n + j] - qd[j];
    }
    for (size_t i = 0; i < p->motion.extra; i++) p->extra[i] = p->c->states[p->c->settings.motion_state[i]];
    held_motion_control(&p->motion, p->time, p->extra, p->deviation, p->u);
}

/* The law of the loop for commands. Actuators without a control have the force nearest to zero. */
static int solve(void *self, const double *q, const double *qd, const double *reference, const double *correction,
                 const double *load, double *forces, double *slack)
{
    struct motion_feedback *p = self;
    const struct controller *c = p->c;
    const struct controller_settings *s = &c->settings;
    (void)correction, (void)load;
    compute_controls(p, q, qd, reference);
    for (size_t i = 0; i < c->a; i++) forces[i] = clip_to(0, c->in_loop.f_min[i], c->in_loop.f_max[i]);
    for (size_t i = 0; i < p->motion.controls; i++) {
        const size_t k = s->motion_actuator[i];
        forces[k] = clip_to(p->u[i], c->in_loop.f_min[k], c->in_loop.f_max[k]);
        if (k < p->m)
            p->commands[k] = clip_to(p->u[i], s->motion_low[i], s->motion_high[i]);
    }
    memset(slack, 0, c->r * sizeof(double));
    return COMPUTED_TORQUE_SOLVED;
}

/* The torque of the forces u. The loop finds the nearest forces within their limits that produce it, or those
   with the smallest acceleration error. */
static int torque(void *self, const double *q, const double *qd, const double *reference, const double *correction,
                  const double *load, double *tau)
{
    struct motion_feedback *p = self;
    const struct controller *c = p->c;
    size_t length;
    const double *L = loop_array(c, "L", &length);
    (void)correction, (void)load;
    compute_controls(p, q, qd, reference);
    memset(c->in_loop.f_p, 0, c->a * sizeof(double));
    memset(tau, 0, p->n * sizeof(double));
    for (size_t i = 0; i < p->motion.controls; i++) {
        const size_t k = c->settings.motion_actuator[i];
        c->in_loop.f_p[k] = p->u[i];
        for (size_t j = 0; j < p->n; j++) tau[j] -= p->u[i] * L[k * p->n + j];
    }
    return 0;
}

void native_motion_set(struct controller *c, double time, double period)
{
    struct motion_feedback *p = c->motion;
    size_t length;
    if (!p)
        return;
    const int looks_ahead = loop_array(c, "delay", &length)[0] != 0 && loop_array(c, "predict", &length)[0] != 0;
    p->time = time + (looks_ahead ? period : 0);
    if (c->settings.motion_use[0] == FEEDFORWARD)
        memcpy(c->in_loop.f_p, held_motion_row(&p->motion, p->time), c->a * sizeof(double));
}

int native_motion_status(const struct controller *c, int status)
{
    const int is_feedback = c->motion && c->settings.motion_use[0] == BY_FORCES;
    return is_feedback && status == COMPUTED_TORQUE_SOFT ? COMPUTED_TORQUE_SOLVED : status;
}

const double *native_motion_commands(const struct controller *c)
{
    return c->motion && c->settings.motion_use[0] == BY_COMMANDS ? c->motion->commands : NULL;
}

void native_motion_close(struct controller *c)
{
    if (!c->motion)
        return;
    free(c->motion->u);
    free(c->motion);
}

static int is_sound(const struct motion_feedback *p, const struct controller_settings *s)
{
    const held_motion *motion = &p->motion;
    int is_valid = motion->rows > 0 && s->motion_use[0] <= BY_COMMANDS &&
                   s->of.motion_numbers.count == motion->rows * held_motion_width(motion) &&
                   native_all_below(s->motion_actuator, motion->controls, p->c->a) &&
                   native_all_below(s->motion_state, motion->extra, s->of.states.count) &&
                   (p->c->r == p->n || s->motion_use[0] == FEEDFORWARD);
    for (size_t k = 1; k < motion->rows; k++) is_valid &= motion->begins[k] > motion->begins[k - 1];
    return is_valid;
}

int native_motion_open(struct controller *c, const struct native_robot *robot, struct text *error)
{
    const struct controller_settings *s = &c->settings;
    if (!s->motion_use[0])
        return 0;
    struct motion_feedback *p = c->motion = calloc(1, sizeof *p);
    const size_t controls = s->of.motion_controls.count, extra = s->of.motion_states.count, nx = 2 * robot->n + extra;
    if (!p || !(p->u = calloc(controls + extra + nx + robot->m, sizeof *p->u))) {
        text_set(error, "not enough memory for the controller");
        return 1;
    }
    p->c = c, p->n = robot->n, p->m = robot->m;
    p->extra = p->u + controls, p->deviation = p->extra + extra, p->commands = p->deviation + nx;
    p->motion = (held_motion){s->of.motion_rows.count, c->a, controls, nx, extra, s->motion_begin, s->motion_values};
    if (!is_sound(p, s)) {
        text_set(error, "native.bin does not match its controller");
        return 1;
    }
    const control_law by_forces = {p, torque, NULL, NULL}, by_commands = {p, NULL, solve, NULL};
    if (s->motion_use[0] != FEEDFORWARD)
        control_loop_set_law(c->loop, s->motion_use[0] == BY_FORCES ? &by_forces : &by_commands);
    return 0;
}
