/* A tick of the control loop. */
#include "loop_state.h"
#include "observer.h"
#include "prediction.h"

#include <string.h>

/* Compute the position error of the reference at q. */
static void position_error(control_loop *s, const real *q, const real *qd, const real *position)
{
    computed_torque *law = s->law;
    if (s->custom.error)
        s->custom.error(s->custom.self, q, position, law->error);
    else if (law->k)
        s->robot.tasks(s->robot.self, q, qd, position, law->error, law->J, law->bias);
    else
        for (size_t j = 0; j < law->n; j++) law->error[j] = position[j] - q[j];
}

/* Solve the law in C, with the torque of a custom law if it exists. */
static int solve(control_loop *s, const real *q, const real *qd, const real *reference)
{
    computed_torque *law = s->law;
    const control_law *custom = &s->custom;
    const real *velocity = reference + law->r, *acceleration = reference + 2 * law->r;
    loop_terms(s, q, qd);
    if (s->robot.gravity && computed_torque_needs_gravity(law)) s->robot.gravity(s->robot.self, q, law->G);
    position_error(s, q, qd, reference);
    for (size_t j = 0; j < law->n; j++) law->load[j] = s->load[j], law->q[j] = q[j], law->qd[j] = qd[j];
    for (size_t i = 0; i < law->r; i++) {
        law->rate_error[i] = velocity[i] - (law->k ? dot(law->n, law->J + i * law->n, qd) : qd[i]);
        law->acceleration[i] = acceleration[i];
        law->correction[i] = s->correction[i];
    }
    if (custom->torque) {
        law->law[0] = COMPUTED_TORQUE_GIVEN;
        if (custom->torque(custom->self, q, qd, reference, s->correction, s->load, law->tau))
            return COMPUTED_TORQUE_FAILED;
    }
    return computed_torque_solve(law);
}

static int solve_custom(control_loop *s, const real *q, const real *qd, const real *reference)
{
    const control_law *custom = &s->custom;
    return custom->solve(custom->self, q, qd, reference, s->correction, s->load, s->law->forces, s->law->slack);
}

static int has_integral(const control_loop *s)
{
    for (size_t i = 0; i < s->law->r; i++)
        if (s->ki[i] != 0) return 1;
    return 0;
}

/* Compute correction += T Ki e if the law is feasible. */
static void integrate(control_loop *s, real T, const real *q, const real *qd, const real *reference)
{
    if (!has_integral(s)) return;
    position_error(s, q, qd, reference);
    for (size_t i = 0; i < s->law->r; i++) s->correction[i] += T * s->ki[i] * s->law->error[i];
}

/* Store the values that the observer compares at the next tick. */
static void store_tick(control_loop *s, const real *q, const real *qd, const real *load)
{
    const size_t n = s->law->n;
    s->has_seen[0] = 1;
    memcpy(s->seen_q, q, n * sizeof(real));
    memcpy(s->seen_qd, qd, n * sizeof(real));
    memcpy(s->seen_forces, s->acting, s->law->m * sizeof(real));
    memcpy(s->seen_load, load, n * sizeof(real));
}

int control_loop_tick(control_loop *s, real T, const real *q, const real *qd, const real *reference,
                      const real *load)
{
    computed_torque *law = s->law;
    const size_t n = law->n, m = law->m;
    const real *at = q, *rate = qd, *desired = reference;
    if (s->gain[0] > 0) loop_observe(s, T, q, qd);
    for (size_t j = 0; j < n; j++) s->load[j] = load[j] + s->disturbance[j];
    if (s->delay[0] && s->predict[0]) {
        loop_predict(s, T, q, qd, s->coming, reference);
        at = s->later, rate = s->faster, desired = s->ahead;
    }
    int status = s->custom.solve ? solve_custom(s, at, rate, desired) : COMPUTED_TORQUE_NEXT;
    if (status == COMPUTED_TORQUE_NEXT) status = solve(s, at, rate, desired);
    if (status == COMPUTED_TORQUE_SOLVED) integrate(s, T, q, qd, reference);
    memcpy(s->acting, s->delay[0] ? s->coming : law->forces, m * sizeof(real));
    memcpy(s->coming, law->forces, m * sizeof(real));
    if (s->gain[0] > 0) store_tick(s, q, qd, load);
    return status;
}
