/* The controller as a native model. Inputs: state, reference and known loads; outputs: muscle forces and
   commands. */
#include "controller.h"

#include "../../../../../sim_dart/csrc/math/elementary.h"
#include "../../platform/clock.h"
#include "controller_settings.h"
#include "policy/policy_law.h"
#include "predictive.h"
#include "ramp.h"
#include "reacting.h"
#include "independent_terms.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double AT_BOUND = 1e-9;

/* ----------------------------------------------------------------- functions of the robot for the loop */

static struct controller *controller_of(const void *robot)
{
    const struct native_model *native =
        (const struct native_model *)((const char *)robot - offsetof(struct native_model, robot));
    return native->data;
}

/* L has the rows of the muscles, then those of the motors. */
static void terms(void *self, const double *q, const double *qd, double *M, double *h, double *L)
{
    struct native_robot *robot = self;
    struct controller *c = controller_of(self);
    const struct controller_settings *s = &c->settings;
    core_move(robot->core, q);
    core_mass_matrix(robot->core);
    core_bias(robot->core, qd);
    memcpy(M, robot->mass_matrix, robot->n * robot->n * sizeof(double));
    core_pulling(robot->core);
    memcpy(L, robot->far ? robot->pull_jacobian : robot->jacobian, robot->m * robot->n * sizeof(double));
    memset(L + robot->m * robot->n, 0, s->of.motors.count * robot->n * sizeof(double));
    for (size_t i = 0; i < s->of.motors.count; i++)
        L[(robot->m + i) * robot->n + s->motors[i]] = -1;
    for (size_t j = 0; j < robot->n; j++)
        h[j] = robot->bias[j] + robot->damping[j] * qd[j];
    native_independent_terms(c, robot, qd, M, h, L);
}

/* Compute G at the state of the last call of `terms`. */
static void gravity(void *self, const double *q, double *G)
{
    struct native_robot *robot = self;
    (void)q;
    core_gravity(robot->core);
    memcpy(G, robot->gravity, robot->n * sizeof(double));
    native_independent_gravity(controller_of(self), robot, G);
}

/* Update the states of cable friction with the joint displacement since the last tick. */
static void update_slips(const struct controller *c, const struct native_robot *robot)
{
    double *has_last = c->last_position, *last = has_last + 1;
    if (!robot->far)
        return;
    for (size_t j = 0; j < robot->n; j++)
        robot->load[j] = has_last[0] != 0 ? c->q[j] - last[j] : 0;
    core_slide(robot->core, robot->load);
    has_last[0] = 1;
    memcpy(last, c->q, robot->n * sizeof(double));
}

/* Return the angle within half a turn, like Python's math.remainder. */
static double nearest_turn(double angle)
{
    const double shifted = angle + PI, rest = fmod(shifted, 2 * PI);
    return (rest < 0 ? rest + 2 * PI : rest) - PI;
}

static void tasks(void *self, const double *q, const double *qd, const double *position, double *error,
                  double *J, double *bias)
{
    struct native_robot *robot = self;
    struct controller *c = controller_of(self);
    core_move(robot->core, q);
    core_task_jacobian(robot->core);
    core_task_bias(robot->core, qd);
    for (size_t i = 0; i < c->k; i++) {
        const size_t row = c->settings.task_rows[i];
        const double left = position[i] - robot->task_values[row];
        error[i] = c->settings.is_angle[i] ? nearest_turn(left) : left;
        bias[i] = robot->task_bias[row];
        memcpy(J + i * robot->n, robot->task_jacobian + row * robot->n, robot->n * sizeof(double));
    }
    native_independent_tasks(c, robot, qd, J, bias);
    if (native_reacting_releases_tasks(c)) {
        memset(error, 0, c->k * sizeof *error);
        memset(bias, 0, c->k * sizeof *bias);
        memset(J, 0, c->k * robot->n * sizeof *J);
    }
}

static void complete(void *self, const double *q, const double *qd, double *qdd)
{
    native_independent_complete(controller_of(self), self, q, qd, qdd);
}

/* ------------------------------------------------------------------------------------- the model */

static void apply_parameters(struct native_model *native)
{
    const struct controller *c = native->data;
    const size_t r = c->r, a = c->a;
    memcpy(c->in_loop.kp, c->kp, r * sizeof(double));
    memcpy(c->in_loop.kd, c->kd, r * sizeof(double));
    memcpy(c->in_loop.f_min, c->f_min, a * sizeof(double));
    memcpy(c->in_loop.f_max, c->f_max, a * sizeof(double));
}

static int check_parameters(struct model *model)
{
    const struct native_model *native = model->backend;
    const struct controller *c = native->data;
    for (size_t i = 0; i < c->a; i++) {
        const int pulls = i < native->robot.m;
        if (!((c->f_min[i] >= 0 || !pulls) && c->f_min[i] <= c->f_max[i] && isfinite(c->f_min[i]))) {
            text_set(&model->error, "%s %.17g is %sabove the upper bound %.17g",
                     native->ports->ports[c->f_min - native->values + i].name, c->f_min[i],
                     pulls ? "negative or " : "", c->f_max[i]);
            return 1;
        }
    }
    for (size_t i = 0; i < c->r; i++)
        if (!(c->kp[i] > 0 && isfinite(c->kp[i]) && c->kd[i] >= 0 && isfinite(c->kd[i]))) {
            text_set(&model->error, "%s %.17g must be above 0, and its kd not negative",
                     native->ports->ports[c->kp - native->values + i].name, c->kp[i]);
            return 1;
        }
    if (!(c->period[0] > 0 && isfinite(c->period[0]))) {
        text_set(&model->error, "period must be a positive time in s, not %.17g", c->period[0]);
        return 1;
    }
    return 0;
}

static void write_commands(const struct controller *c)
{
    for (size_t i = 0; i < c->settings.of.commands.count; i++)
        c->commands[i] = c->muscles.commands[c->settings.commanded[i]];
}

/* Muscles with laws hold the robot until the first tick. */
static void hold_robot(const struct native_model *native)
{
    struct controller *c = native->data;
    const size_t size = native->robot.m * sizeof(double);
    native_muscles_reset(&c->muscles);
    memcpy(c->forces, c->settings.start_forces, size);
    memcpy(c->in_loop.acting, c->settings.start_forces, size);
    memcpy(c->in_loop.coming, c->settings.start_forces, size);
    write_commands(c);
}

static int initialize(struct model *model)
{
    struct native_model *native = model->backend;
    const struct native_robot *robot = &native->robot;
    const struct controller *c = native->data;
    if (check_parameters(model))
        return 1;
    apply_parameters(native);
    control_loop_reset(c->loop);
    memcpy(c->forces, c->in_loop.acting, c->a * sizeof(double));
    if (c->muscles.are_modelled)
        hold_robot(native);
    native_ramp_reset((struct controller *)native->data, c->forces);
    native_reacting_reset(native->data);
    native_predictive_reset(c);
    memset(c->slack, 0, c->r * sizeof(double));
    memset(c->report, 0, c->settings.of.report.count * sizeof(double));
    memset(c->last_position, 0, (1 + robot->n) * sizeof(double));
    memset(robot->slips, 0, robot->bends * sizeof(double));
    return 0;
}

static size_t count_at_bounds(const struct controller *c, size_t count_of_all)
{
    const double *forces = c->in_loop.forces;
    const double *f_min = c->in_loop.f_min, *f_max = c->in_loop.f_max;
    size_t count = 0;
    for (size_t i = 0; i < count_of_all; i++) {
        const double low = f_min[i], high = isfinite(f_max[i]) ? f_max[i] : DBL_MAX;
        count += forces[i] - low <= AT_BOUND * fmax(1, low) || high - forces[i] <= AT_BOUND * fmax(1, high);
    }
    return count;
}

static int are_inputs_finite(const struct controller *c)
{
    return native_all_finite(c->q, c->settings.of.q.count) && native_all_finite(c->qd, c->settings.of.qd.count) &&
           native_all_finite(c->reference, c->settings.of.reference.count) &&
           native_all_finite(c->loads, c->settings.of.loads.count) &&
           native_all_finite(c->estimated_loads, c->settings.of.estimated_loads.count) &&
           native_all_finite(c->states, c->settings.of.states.count);
}

/* Restrict the forces of the loop to those that the muscles can reach. */
static void limit_to_reachable(const struct native_model *native, double period)
{
    struct controller *c = native->data;
    struct native_muscles *muscles = &c->muscles;
    const struct native_robot *robot = &native->robot;
    const size_t size = robot->m * sizeof(double);
    native_muscles_set_state(muscles, robot, c->q, c->qd, c->states, c->f_min, c->f_max, period);
    for (size_t i = 0; i < robot->m; i++)
        for (size_t j = 0; muscles->passive_push[i] != 0 && j < robot->n; j++)
            robot->load[j] += robot->jacobian[i * robot->n + j] * muscles->passive_push[i];
    memcpy(c->in_loop.f_min, muscles->least, size);
    memcpy(c->in_loop.f_max, muscles->most, size);
    if (muscles->has_ticked[0] != 0) /* the observer needs the forces that acted */
        memcpy(c->in_loop.seen_forces, muscles->applied, size);
}

/* Compute a tick without a state: commands decrease. */
static void ramp_down(struct native_model *native, double period)
{
    struct controller *c = native->data;
    struct native_robot *robot = &native->robot;
    native_ramp_down(c, period);
    native_predictive_reset(c);
    c->last_position[0] = 0;
    if (c->muscles.are_modelled) { /* at the last positions, and at rest */
        const double *q = c->ramp + 1 + c->a;
        memset(robot->load, 0, robot->n * sizeof(double));
        native_muscles_set_state(&c->muscles, robot, q, robot->load, c->states, c->f_min, c->f_max, period);
        native_muscles_update(&c->muscles, robot, q, robot->load, c->forces, period);
        write_commands(c);
    }
    memset(c->slack, 0, c->r * sizeof(double));
    memset(c->report, 0, c->settings.of.report.count * sizeof(double));
}

/* Set the commands of the muscles for the forces of a tick, or those of an optimal motion. */
static void command_muscles(struct native_model *native, double period)
{
    struct controller *c = native->data;
    const double *commands = native_motion_commands(c);
    if (commands) {
        native_muscles_command(&c->muscles, &native->robot, c->q, c->qd, commands);
        memcpy(c->forces, c->muscles.began, native->robot.m * sizeof(double));
    } else
        native_muscles_update(&c->muscles, &native->robot, c->q, c->qd, c->forces, period);
    write_commands(c);
}

static int step(struct model *model)
{
    struct native_model *native = model->backend;
    struct native_robot *robot = &native->robot;
    struct controller *c = native->data;
    const size_t periods =
        native_whole_steps(native->clock[1], c->period, "the controller's period", model);
    if (!periods || check_parameters(model))
        return 1;
    const double period = (double)periods * c->period[0];
    apply_parameters(native);
    if (native_ramp_is_due(c)) {
        ramp_down(native, period);
        return 0;
    }
    if (c->policy.layers) {
        native_policy_tick(c, robot, period);
        return 0;
    }
    const double share = c->settings.observer[0] * period;
    c->in_loop.gain[0] = c->predictive ? fmin(share, 1) : 1 - exponential(-share); /* see observer.c */
    if (!are_inputs_finite(c) || core_move_checked(robot->core, c->q, c->qd)) {
        text_set(&model->error, "the state or the reference of the controller is not finite");
        return 1;
    }
    update_slips(c, robot);
    const double begin = monotonic_seconds();
    native_robot_load(robot, c->settings.load_rows, c->settings.of.loads.count, c->loads, -1); /* w_e = -J'F */
    for (size_t j = 0; j < c->settings.of.estimated_loads.count; j++)
        robot->load[j] += c->estimated_loads[j];
    if (c->muscles.are_modelled)
        limit_to_reachable(native, period);
    native_independent_load(c, robot, c->q, c->qd, robot->load);
    const double *reference = native_reacting_set(c, robot);
    native_predictive_set(c, native->clock[0], period);
    native_motion_set(c, native->clock[0], period);
    int status = control_loop_tick(c->loop, period, c->q, c->qd, reference, robot->load);
    status = native_motion_status(c, status);
    if (c->undetermined) {
        text_set(&model->error, "%s is not determined by the independent coordinates of the closed loops at this pose",
                 native->ports->ports[c->q - native->values + c->undetermined - 1].name);
        c->undetermined = 0;
        return 1;
    }
    if (status >= COMPUTED_TORQUE_FAILED) {
        text_set(&model->error, "no forces within the limits produce the required motion: the QP failed");
        return 1;
    }
    native_reacting_finish(c, period, status != COMPUTED_TORQUE_SOLVED);
    native_ramp_up(c, period);
    memcpy(c->forces, c->in_loop.acting, c->a * sizeof(double));
    if (c->muscles.are_modelled)
        command_muscles(native, period);
    memcpy(c->slack, c->in_loop.slack, c->r * sizeof(double));
    c->report[0] = (double)count_at_bounds(c, c->a);
    c->report[1] = monotonic_seconds() - begin;
    c->report[2] = status == COMPUTED_TORQUE_SOFT;
    c->report[3] = status == COMPUTED_TORQUE_NOT_CONVERGED;
    if (c->k)
        c->report[4] = c->in_loop.limits_dropped[0];
    native_predictive_report(c, c->report + (c->k ? 5 : 4));
    return 0;
}

static size_t list_state(struct native_model *native, double **parts, size_t *sizes)
{
    struct controller *c = native->data;
    const struct native_robot *robot = &native->robot;
    parts[0] = loop_array(c, "remembered", &sizes[0]);
    parts[1] = loop_array(c, "memory", &sizes[1]);
    parts[2] = c->muscles.memory, sizes[2] = native_muscles_memory(&c->muscles);
    parts[3] = c->ramp, sizes[3] = native_ramp_memory(c);
    parts[4] = robot->slips, sizes[4] = robot->bends;
    parts[5] = c->last_position, sizes[5] = robot->far ? 1 + robot->n : 0;
    parts[6] = native_predictive_memory(c, &sizes[6]);
    parts[7] = native_reacting_memory(c, &sizes[7]);
    return 8;
}

static void free_controller(void *data)
{
    struct controller *c = data;
    native_muscles_close(&c->muscles);
    native_motion_close(c);
    free(c->ramp);
    free(c->last_position);
    native_reacting_close(c);
    native_policy_close(c);
    free(c->loop);
    native_predictive_close(c);
    free(c);
}

/* ----------------------------------------------------------------------------------- opening it */

static int open_loop(struct native_model *native, struct controller *c)
{
    native_independent_open(c, &native->robot);
    const struct native_robot *robot = &native->robot;
    const control_robot without = {&native->robot, terms, tasks, NULL, NULL, gravity};
    const control_robot with_loops = {&native->robot, terms, tasks, complete, c->settings.dependent, gravity};
    const control_robot asked = c->has_dependent ? with_loops : without;
    const int n = (int)robot->n, a = (int)c->a, k = (int)c->k;
    const size_t size = control_loop_size(n, a, k);
    void *memory = size ? malloc(size) : NULL;
    c->loop = memory ? control_loop_open(&asked, n, a, k, memory) : NULL;
    return !c->loop;
}

static int open_slips(struct controller *c, const struct native_robot *robot)
{
    c->last_position = calloc(1 + robot->n, sizeof *c->last_position);
    return !c->last_position;
}

static int open_controller(struct model *model, struct native_model *native, struct text *error)
{
    struct controller *c = native->data;
    if (native_controller_settings(c, native, error))
        return 1;
    if (native_muscles_open(&c->muscles, &native->robot, &c->settings) || native_ramp_open(c) ||
        open_slips(c, &native->robot) || open_loop(native, c)) {
        text_set(error, "not enough memory for the controller");
        return 1;
    }
    if (native_policy_open(c)) {
        text_set(error, "native.bin does not match its policy");
        return 1;
    }
    (void)model;
    return native_predictive_open(c, native, tasks, error) || native_controller_fill(c, native, error) ||
        native_motion_open(c, &native->robot, error) || native_reacting_open(c, &native->robot, error);
}

const struct native_functions native_controller = {
    .model = {.initialize = initialize, .step = step, NATIVE_FUNCTIONS},
    .size = sizeof(struct controller),
    .open = open_controller,
    .list_state = list_state,
    .release = free_controller,
};

static struct controller *controller_in(struct model *model)
{
    const struct native_model *native = model->backend;
    return model->functions == &native_controller.model ? native->data : NULL;
}

int native_controller_use(struct model *model, const control_law *law, const struct muscle_functions *muscles)
{
    struct controller *c = controller_in(model);
    if (!c)
        return 1;
    if (law->torque || law->solve)
        control_loop_set_law(c->loop, law);
    c->muscles.outside = *muscles;
    return 0;
}

double *native_controller_array(struct model *model, const char *name, size_t *length)
{
    const struct controller *c = controller_in(model);
    double *array = c ? native_predictive_array(c, name, length) : NULL;
    return array || !c ? array : loop_array(c, name, length);
}
