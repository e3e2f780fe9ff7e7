/* The loop around a computed-torque law. */
#include "control_loop.h"

#include "../../../sim_dart/csrc/math/cholesky.h"
#include "state.h"

#include <string.h>

/* ARRAY(name, number of doubles); those from acting to seen_load are what the loop remembers. */
#define LOOP_ARRAYS(ARRAY)                                                                             \
    ARRAY(ki, r)                                                                                       \
    ARRAY(gain, 1)                                                                                     \
    ARRAY(delay, 1)                                                                                    \
    ARRAY(predict, 1)                                                                                  \
    ARRAY(acting, m)                                                                                   \
    ARRAY(coming, m)                                                                                   \
    ARRAY(correction, r)                                                                               \
    ARRAY(disturbance, n)                                                                              \
    ARRAY(has_seen, 1)                                                                                 \
    ARRAY(seen_q, n)                                                                                   \
    ARRAY(seen_qd, n)                                                                                  \
    ARRAY(seen_forces, m)                                                                              \
    ARRAY(seen_load, n)                                                                                \
    ARRAY(load, n)                                                                                     \
    ARRAY(later, n)                                                                                    \
    ARRAY(faster, n)                                                                                   \
    ARRAY(half_way, n)                                                                                 \
    ARRAY(qdd, n)                                                                                      \
    ARRAY(position, r)                                                                                 \
    ARRAY(velocity, r)                                                                                 \
    ARRAY(error, r)

#define LOOP_MEMBER(name, length) real *name;
struct control_loop {
    control_robot robot;
    computed_torque *law;
    LOOP_ARRAYS(LOOP_MEMBER)
};
#undef LOOP_MEMBER

static size_t padded(size_t size)
{
    return (size + 7u) & ~(size_t)7u;
}

size_t control_loop_size(int coordinates, int muscles, int tasks)
{
    const size_t law = computed_torque_size(coordinates, muscles, tasks);
    if (!law) return 0;
    const size_t n = (size_t)coordinates, m = (size_t)muscles, r = tasks ? (size_t)tasks : n;
    size_t doubles = 0;
#define ADD_LENGTH(name, length) doubles += length;
    LOOP_ARRAYS(ADD_LENGTH)
#undef ADD_LENGTH
    return padded(sizeof(control_loop)) + padded(law) + doubles * sizeof(real);
}

control_loop *control_loop_open(const control_robot *robot, int coordinates, int muscles, int tasks,
                                void *memory)
{
    const size_t size = control_loop_size(coordinates, muscles, tasks);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    control_loop *s = memory;
    s->robot = *robot;
    char *at = (char *)memory + padded(sizeof *s);
    s->law = computed_torque_open(coordinates, muscles, tasks, at);
    at += padded(computed_torque_size(coordinates, muscles, tasks));
    const size_t n = s->law->n, m = s->law->m, r = s->law->r;
#define PLACE(name, length) s->name = (real *)(void *)at, at += (length) * sizeof(real);
    LOOP_ARRAYS(PLACE)
#undef PLACE
    return s;
}

computed_torque *control_loop_law(control_loop *s)
{
    return s->law;
}

real *control_loop_array(control_loop *s, const char *name, size_t *length)
{
    const size_t n = s->law->n, m = s->law->m, r = s->law->r;
    if (!strcmp(name, "remembered")) return *length = 3 * m + r + 4 * n + 1, s->acting;
#define FIND(name_, length_) \
    if (!strcmp(name, #name_)) return *length = length_, s->name_;
    LOOP_ARRAYS(FIND)
#undef FIND
    return NULL;
}

void control_loop_reset(control_loop *s)
{
    size_t length;
    computed_torque_reset(s->law);
    memset(control_loop_array(s, "remembered", &length), 0, (3 * s->law->m + s->law->r + 4 * s->law->n + 1) * sizeof(real));
    memcpy(s->acting, s->law->forces, s->law->m * sizeof(real));
    memcpy(s->coming, s->law->forces, s->law->m * sizeof(real));
}

static void terms_at(control_loop *s, const real *q, const real *qd)
{
    s->robot.terms(s->robot.self, q, qd, s->law->M, s->law->h, s->law->L);
}

/* Compare the velocity with what the model made of the last tick's forces. */
static void observe(control_loop *s, real period, const real *qd)
{
    const computed_torque *law = s->law;
    const size_t n = law->n;
    if (!s->has_seen[0]) return;
    terms_at(s, s->seen_q, s->seen_qd);
    for (size_t j = 0; j < n; j++) s->qdd[j] = (qd[j] - s->seen_qd[j]) / period;
    for (size_t j = 0; j < n; j++) {
        if (s->robot.dependent && s->robot.dependent[j] != 0) continue; /* its load moves the others */
        real seen = -law->h[j] - dot(n, law->M + j * n, s->qdd) - s->seen_load[j];
        for (size_t i = 0; i < law->m; i++) seen -= law->L[i * n + j] * s->seen_forces[i];
        s->disturbance[j] += s->gain[0] * (seen - s->disturbance[j]);
    }
}

/* qdd = -M^-1 (L'f + h + w) */
static void accelerate(control_loop *s, const real *q, const real *qd, const real *forces)
{
    computed_torque *law = s->law;
    terms_at(s, q, qd);
    for (size_t j = 0; j < law->n; j++) s->qdd[j] = -law->h[j] - s->load[j];
    for (size_t i = 0; i < law->m; i++) add(law->n, s->qdd, -forces[i], law->L + i * law->n);
    if (!cholesky_factor(law->n, law->M, law->factor)) cholesky_solve(law->n, law->factor, s->qdd);
    if (s->robot.complete) s->robot.complete(s->robot.self, q, qd, s->qdd);
}

/* The state one period on, by the midpoint rule: later and faster. */
static void predict(control_loop *s, real T, const real *q, const real *qd, const real *forces)
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
}

/* What is still to go to a position of the reference, at q. */
static void remaining(control_loop *s, const real *q, const real *qd, const real *position)
{
    computed_torque *law = s->law;
    if (law->k)
        s->robot.tasks(s->robot.self, q, qd, position, law->error, law->J, law->bias);
    else
        for (size_t j = 0; j < law->n; j++) law->error[j] = position[j] - q[j];
}

static int solve(control_loop *s, const real *q, const real *qd, const real *position,
                 const real *velocity, const real *acceleration)
{
    computed_torque *law = s->law;
    terms_at(s, q, qd);
    remaining(s, q, qd, position);
    for (size_t j = 0; j < law->n; j++) law->h[j] += s->load[j], law->q[j] = q[j], law->qd[j] = qd[j];
    for (size_t i = 0; i < law->r; i++) {
        law->rate_error[i] = velocity[i] - (law->k ? dot(law->n, law->J + i * law->n, qd) : qd[i]);
        law->acceleration[i] = acceleration[i] + s->correction[i];
    }
    return computed_torque_solve(law);
}

int control_loop_tick(control_loop *s, real T, const real *q, const real *qd, const real *reference,
                      const real *load)
{
    computed_torque *law = s->law;
    const size_t n = law->n, m = law->m, r = law->r;
    const real *position = reference, *velocity = reference + r, *acceleration = reference + 2 * r;
    if (s->gain[0] > 0) observe(s, T, qd);
    for (size_t j = 0; j < n; j++) s->load[j] = load[j] + s->disturbance[j];
    const real *at = q, *rate = qd;
    if (s->delay[0] && s->predict[0]) {
        predict(s, T, q, qd, s->coming);
        at = s->later, rate = s->faster;
        for (size_t i = 0; i < r; i++) {
            s->position[i] = position[i] + T * velocity[i] + 0.5 * T * T * acceleration[i];
            s->velocity[i] = velocity[i] + T * acceleration[i];
        }
        position = s->position, velocity = s->velocity;
    }
    const int status = solve(s, at, rate, position, velocity, acceleration);
    if (status == COMPUTED_TORQUE_SOLVED) {
        remaining(s, q, qd, reference);
        for (size_t i = 0; i < r; i++) s->correction[i] += T * s->ki[i] * law->error[i];
    }
    memcpy(s->acting, s->delay[0] ? s->coming : law->forces, m * sizeof(real));
    memcpy(s->coming, law->forces, m * sizeof(real));
    if (s->gain[0] > 0) {
        s->has_seen[0] = 1;
        memcpy(s->seen_q, q, n * sizeof(real));
        memcpy(s->seen_qd, qd, n * sizeof(real));
        memcpy(s->seen_forces, s->acting, m * sizeof(real));
        memcpy(s->seen_load, load, n * sizeof(real));
    }
    return status;
}
