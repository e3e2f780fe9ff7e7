/* The model of the external FMUs: two joints pulled by four cables, in their own units. */
#ifndef BODY_H
#define BODY_H

#include <stddef.h>

enum { CABLES = 4, JOINTS = 2 };

static const double LEVERS[JOINTS][CABLES] = {{0.1, -0.1, 0.05, -0.05}, {0.0, 0.02, 0.1, -0.1}};
static const double DEGREES = 57.29577951308232;

typedef struct {
    double pulls[CABLES]; /* kN */
    double angles[JOINTS]; /* deg */
    double rates[JOINTS]; /* deg/s */
    double inertia; /* kg.m2 */
    int brake;
} body;

static void body_start(body *b)
{
    *b = (body){.angles = {-28.64788975654116, 28.64788975654116}, .inertia = 2.0};
}

/* Bodies with these inertias stop after a while. */
static inline int is_stuck(const body *b, double t)
{
    return b->inertia == 1e6 && t > 0.0095;
}

static inline int ends(const body *b, double t)
{
    return b->inertia == 1e7 && t > 0.0095;
}

static void body_step(body *b, double h)
{
    for (size_t i = 0; i < JOINTS && !b->brake; i++) {
        double torque = 0.0;
        for (size_t k = 0; k < CABLES; k++) {
            torque += LEVERS[i][k] * 1000.0 * b->pulls[k];
        }
        b->rates[i] += h * torque / b->inertia * DEGREES;
        b->angles[i] += h * b->rates[i];
    }
}

#endif
