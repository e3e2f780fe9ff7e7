/* The settings of a native controller, after those of the robot and of the muscles, and whether it is in
 * operational space: ki (r), bandwidth of the observer in rad/s, delay, predict; H_f (m); and in
 * operational space whether each task is an angle (k), H_q (n), H_r (m), f_p (m), W (k), posture kp (n),
 * posture kd (n), q0 (n), bandwidth of the limits, or 0. */
#include "controller_settings.h"

#include <string.h>

static int take(struct native_file *file, double *to, size_t count)
{
    const double *from = native_file_take(file, count);
    if (from)
        memcpy(to, from, count * sizeof(double));
    return !from;
}

static int take_tasks(struct controller *c, const struct native_robot *robot, struct native_file *file)
{
    const size_t n = robot->n, m = robot->m, k = robot->k;
    c->is_angle = native_file_take(file, k);
    memcpy(law_array(c, "q_min"), robot->lower, n * sizeof(double));
    memcpy(law_array(c, "q_max"), robot->upper, n * sizeof(double));
    return !c->is_angle || take(file, law_array(c, "H_q"), n) || take(file, law_array(c, "H_r"), m) ||
           take(file, law_array(c, "f_p"), m) || take(file, law_array(c, "W"), k) ||
           take(file, law_array(c, "posture_kp"), n) || take(file, law_array(c, "posture_kd"), n) ||
           take(file, law_array(c, "q0"), n) || take(file, law_array(c, "limit_bandwidth"), 1);
}

int native_controller_settings(struct controller *c, struct native_model *native)
{
    struct native_file *file = &native->file;
    size_t length;
    return take(file, loop_array(c, "ki", &length), c->r) || take(file, &c->observer, 1) ||
           take(file, loop_array(c, "delay", &length), 1) ||
           take(file, loop_array(c, "predict", &length), 1) ||
           take(file, law_array(c, "H_f"), native->robot.m) ||
           (c->k && take_tasks(c, &native->robot, file)) || file->settings_count;
}
