/* Prediction of the state after one period, when the forces of a delayed law take effect, by the midpoint
   rule:

     qdd = -M^-1 (L'f + h + w)
     later = q + T (qd + T/2 qdd(q, qd)),   faster = qd + T qdd(q + T/2 qd, qd + T/2 qdd(q, qd)) */
#include "prediction.h"

#include "../../../sim_dart/csrc/math/cholesky.h"

static void accelerate(control_loop *s, const real *q, const real *qd, const real *forces)
{
    computed_torque *law = s->law;
    loop_terms(s, q, qd);
    for (size_t j = 0; j < law->n; j++) s->qdd[j] = -law->h[j] - s->load[j];
    for (size_t i = 0; i < law->m; i++) add(law->n, s->qdd, -forces[i], law->L + i * law->n);
    if (!cholesky_factor(law->n, law->M, law->factor)) cholesky_solve(law->n, law->factor, s->qdd);
    if (s->robot.complete) s->robot.complete(s->robot.self, q, qd, s->qdd);
}

/* The acceleration of the reference is constant. */
static void predict_reference(control_loop *s, real T, const real *reference)
{
    const size_t r = s->law->r;
    const real *position = reference, *velocity = reference + r, *acceleration = reference + 2 * r;
    for (size_t i = 0; i < r; i++) {
        s->ahead[i] = position[i] + T * velocity[i] + 0.5 * T * T * acceleration[i];
        s->ahead[r + i] = velocity[i] + T * acceleration[i];
        s->ahead[2 * r + i] = acceleration[i];
    }
}

void loop_predict(control_loop *s, real T, const real *q, const real *qd, const real *forces, const real *reference)
{
    const size_t n = s->law->n;
    accelerate(s, q, qd, forces);
    for (size_t j = 0; j < n; j++) {
        s->half_way[j] = qd[j] + 0.5 * T * s->qdd[j];
        s->later[j] = q[j] + 0.5 * T * qd[j];
    }
    accelerate(s, s->later, s->half_way, forces);
    for (size_t j = 0; j < n; j++) {
        s->later[j] = q[j] + T * s->half_way[j];
        s->faster[j] = qd[j] + T * s->qdd[j];
    }
    predict_reference(s, T, reference);
}
