#include "independent.h"

#include <stdlib.h>
#include <string.h>

/* N and c at the core's last q; nonzero where the robot has no dependent coordinates. */
static int move(struct controller *c, const struct native_robot *robot, const double *qd)
{
    if (!c->room)
        return 1;
    const int undetermined = core_free_motion(robot->core, c->settings.dependent, qd);
    if (undetermined)
        c->undetermined = undetermined;
    return 0;
}

int native_independent_open(struct controller *c, const struct native_robot *robot)
{
    const size_t n = robot->n;
    int has_dependent = 0;
    for (size_t j = 0; j < n; j++)
        has_dependent |= c->settings.dependent[j] != 0;
    if (!has_dependent)
        return 0;
    size_t length;
    c->N = core_array(robot->core, "free_motion", &length);
    c->bias = core_array(robot->core, "free_bias", &length);
    c->room = length == n ? calloc(n * n + n, sizeof *c->room) : NULL;
    return !c->room;
}

/* row = row N */
static void narrow(const struct controller *c, size_t n, double *row)
{
    double *wide = c->room + n * n;
    memcpy(wide, row, n * sizeof *row);
    memset(row, 0, n * sizeof *row);
    for (size_t k = 0; k < n; k++)
        for (size_t j = 0; j < n; j++)
            row[j] += wide[k] * c->N[k * n + j];
}

static double product(size_t n, const double *a, const double *b)
{
    double sum = 0;
    for (size_t j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

void native_independent_terms(struct controller *c, const struct native_robot *robot, const double *qd, double *M,
                              double *h, double *L)
{
    const size_t n = robot->n;
    if (move(c, robot, qd))
        return;
    for (size_t j = 0; j < n; j++)
        h[j] += product(n, M + j * n, c->bias);
    narrow(c, n, h);
    for (size_t i = 0; i < c->a; i++)
        narrow(c, n, L + i * n);
    for (size_t j = 0; j < n; j++) { /* (M N)', whose rows are those of N'M as M is symmetric */
        narrow(c, n, M + j * n);
        for (size_t k = 0; k < n; k++)
            c->room[k * n + j] = M[j * n + k];
    }
    for (size_t k = 0; k < n; k++) {
        memcpy(M + k * n, c->room + k * n, n * sizeof *M);
        narrow(c, n, M + k * n);
        if (c->settings.dependent[k] != 0)
            M[k * n + k] = 1;
    }
}

void native_independent_tasks(struct controller *c, const struct native_robot *robot, const double *qd, double *J,
                              double *bias)
{
    const size_t n = robot->n;
    if (move(c, robot, qd))
        return;
    for (size_t i = 0; i < c->k; i++) {
        bias[i] += product(n, J + i * n, c->bias);
        narrow(c, n, J + i * n);
    }
}

void native_independent_load(struct controller *c, const struct native_robot *robot, const double *q,
                             const double *qd, double *load)
{
    if (!c->room)
        return;
    core_move(robot->core, q);
    if (!move(c, robot, qd))
        narrow(c, robot->n, load);
}

void native_independent_complete(struct controller *c, const struct native_robot *robot, const double *q,
                                 const double *qd, double *qdd)
{
    const size_t n = robot->n;
    if (!c->room)
        return;
    core_move(robot->core, q);
    move(c, robot, qd);
    double *own = c->room;
    memcpy(own, qdd, n * sizeof *qdd);
    for (size_t j = 0; j < n; j++)
        qdd[j] = product(n, c->N + j * n, own) + c->bias[j];
}
