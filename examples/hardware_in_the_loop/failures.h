/* Failures of the simulated robot at stated times, KIND:NUMBER[=VALUE]@TIME: the kinds of `cardsflow device --fault`.
 * NUMBER is the muscle, or the joint of encoder_stuck, from 0 on. Included by simulated_robot.h. */
#ifndef FAILURES_H
#define FAILURES_H

#include <stdio.h>
#include <stdlib.h>

#define KINDS_TEXT                                                                                            \
    "kinds: broken, jammed=STIFFNESS, weak=FACTOR, off_pulley=LENGTH, length_stuck, length_bias=LENGTH, "     \
    "length_drift=RATE, length_scale=FACTOR, length_swapped=NUMBER, tension_stuck, tension_dead, encoder_stuck"
enum failure_kind {
    BROKEN, JAMMED, WEAK, OFF_PULLEY, LENGTH_STUCK, LENGTH_BIAS, LENGTH_DRIFT, LENGTH_SCALE, LENGTH_SWAPPED,
    TENSION_STUCK, TENSION_DEAD, ENCODER_STUCK, KINDS
};
static const char *const KIND_NAMES[KINDS] = {
    "broken", "jammed", "weak", "off_pulley", "length_stuck", "length_bias", "length_drift", "length_scale", "length_swapped",
    "tension_stuck", "tension_dead", "encoder_stuck"};
enum { MAX_FAILURES = 16 };

static struct failure {
    enum failure_kind kind;
    int part, motor_failed, sensor_failed; /* whether the values at the failure are known */
    double value, time;
    double force, length, reading;
} failures[MAX_FAILURES];
static int failure_count;

/* Return nonzero if the kind requires a value. */
static int needs_value(enum failure_kind kind)
{
    return kind == JAMMED || kind == WEAK || (kind >= OFF_PULLEY && kind != LENGTH_STUCK && kind <= LENGTH_SWAPPED);
}

/* Read a failure. Return 0 if it is invalid, or if there are too many. */
static int failures_add(const char *text)
{
    struct failure f = {0};
    char kind[20], number[20], value[30] = "0", time[30], rest;
    const char *const forms[] = {"%19[a-z_]:%19[0-9]=%29[^@]@%29[0-9.e+-]%c", "%19[a-z_]:%19[0-9]@%29[0-9.e+-]%c"};
    const int has_value = sscanf(text, forms[0], kind, number, value, time, &rest) == 4;
    if (failure_count == MAX_FAILURES || (!has_value && sscanf(text, forms[1], kind, number, time, &rest) != 3))
        return 0;
    while (f.kind < KINDS && strcmp(kind, KIND_NAMES[f.kind]))
        f.kind++;
    char *end_of_value, *end_of_time;
    const long part = strtol(number, NULL, 10), parts = f.kind == ENCODER_STUCK ? ENCODERS : MUSCLES;
    f.part = (int)part, f.value = strtod(value, &end_of_value), f.time = strtod(time, &end_of_time);
    if (f.kind == KINDS || part >= parts || has_value != needs_value(f.kind) || *end_of_value || *end_of_time ||
        (f.kind == LENGTH_SWAPPED && !(f.value >= 0 && f.value < MUSCLES)))
        return 0;
    failures[failure_count++] = f;
    return 1;
}

static void failures_reset(void)
{
    for (int k = 0; k < failure_count; k++)
        failures[k].motor_failed = failures[k].sensor_failed = 0;
}

/* Return the tension of a cable with the failures until now. */
static double failed_tension(int i)
{
    double force = tension[i];
    for (struct failure *f = failures; f < failures + failure_count; f++) {
        if (f->part != i || f->time > robot_time)
            continue;
        if (f->kind == JAMMED && !f->motor_failed)
            f->motor_failed = 1, f->force = force, f->length = length_of(i);
        if (f->kind == JAMMED)
            force = fmax(f->force + f->value * (length_of(i) - f->length), 0);
        else if (f->kind == WEAK || f->kind == BROKEN)
            force *= f->value; /* 0 for broken cables */
    }
    return force;
}

/* Return the reading of a sensor when its failure began. */
static double first_reading(struct failure *f, double now)
{
    if (!f->sensor_failed)
        f->sensor_failed = 1, f->reading = now;
    return f->reading;
}

/* Apply the failures until now to the measurements: encoders (positions, then velocities), lengths, tensions. */
static void failures_measure(double *encoders, double *lengths, double *tensions)
{
    for (struct failure *f = failures; f < failures + failure_count; f++) {
        if (f->time > robot_time)
            continue;
        double *length = lengths + (f->kind == ENCODER_STUCK ? 0 : f->part), kept = *length;
        switch (f->kind) {
        case BROKEN: case LENGTH_STUCK: *length = first_reading(f, *length); break;
        case OFF_PULLEY: case LENGTH_BIAS: *length += f->value; break;
        case LENGTH_DRIFT: *length += f->value * (robot_time - f->time); break;
        case LENGTH_SCALE: *length = first_reading(f, kept) + f->value * (kept - first_reading(f, kept)); break;
        case LENGTH_SWAPPED: *length = lengths[(int)f->value], lengths[(int)f->value] = kept; break;
        case TENSION_STUCK: tensions[f->part] = first_reading(f, tensions[f->part]); break;
        case TENSION_DEAD: tensions[f->part] = 0; break;
        case ENCODER_STUCK: encoders[f->part] = first_reading(f, encoders[f->part]), encoders[ENCODERS + f->part] = 0; break;
        case JAMMED: *length = f->motor_failed ? f->length : kept; break; /* the motor does not turn */
        case WEAK: case KINDS: break;
        }
    }
}

#endif
