/* A simulated robot for device.c: tensions follow commands, and joints follow tensions, with first-order lags; muscle i
 * moves joint i % JOINTS, with alternating sign. Muscles and their sensors can fail, see failures.h. */
#ifndef SIMULATED_ROBOT_H
#define SIMULATED_ROBOT_H

#include <math.h>
#include <string.h>

#ifndef JOINTS
#define JOINTS 2
#define MUSCLES 4
#define ENCODERS JOINTS /* or 0: hardware.has_positions = false */
#endif
#ifndef START /* positions with equal tensions: -DSTART=0.1,0.2 */
#define START 0.0
#endif
enum { COMMANDS = MUSCLES, STATES = 2 * ENCODERS + 2 * MUSCLES };

static const double F_MIN = 10.0, F_MAX = 500.0;                 /* [N] */
static const double MOTOR_LAG = 0.005, JOINT_LAG = 0.1;          /* [s] */
static const double COMPLIANCE = 1e-3, LENGTH = 0.3, ARM = 0.02; /* [rad/N], [m], [m] */
static double q[JOINTS] = {START}, qd[JOINTS], command[MUSCLES], tension[MUSCLES];
static double robot_time; /* since the start, in [s] */

static double direction(int i) { return i / JOINTS % 2 ? -1.0 : 1.0; }

static void robot_apply(int i, double force) { command[i] = force; }

static double length_of(int i) { return LENGTH - direction(i) * ARM * q[i % JOINTS]; }

#include "failures.h"

static void robot_safe(void)
{
    for (int i = 0; i < MUSCLES; i++)
        command[i] = F_MIN;
}

static void robot_reset(void)
{
    robot_safe();
    memcpy(tension, command, sizeof tension);
    robot_time = 0, failures_reset();
    memcpy(q, (const double[JOINTS]){START}, sizeof q), memset(qd, 0, sizeof qd);
}

static void robot_advance(double dt)
{
    double goal[JOINTS] = {START};
    robot_time += dt;
    for (int i = 0; i < MUSCLES; i++) {
        tension[i] += (command[i] - tension[i]) * dt / (MOTOR_LAG + dt);
        goal[i % JOINTS] += direction(i) * COMPLIANCE * failed_tension(i);
    }
    for (int j = 0; j < JOINTS; j++)
        qd[j] = (goal[j] - q[j]) / (JOINT_LAG + dt), q[j] += qd[j] * dt;
}

static void robot_state(double *values)
{
    for (int j = 0; j < ENCODERS; j++)
        values[j] = q[j], values[ENCODERS + j] = qd[j];
    for (int i = 0; i < MUSCLES; i++) {
        values[2 * ENCODERS + i] = length_of(i);
        values[2 * ENCODERS + MUSCLES + i] = failed_tension(i);
    }
    failures_measure(values, values + 2 * ENCODERS, values + 2 * ENCODERS + MUSCLES);
}

#endif
