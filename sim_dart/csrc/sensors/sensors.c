#include "sensors.h"

#include "../kinematics/bodies.h"
#include "../kinematics/points.h"
#include "../math/elementary.h"
#include "random.h"
#include "specific_force.h"

#include <string.h>

enum { MAX_IMUS = 64, MAX_DELAY = 100000 };

#define SENSORS_REMEMBERED(ARRAY)                                                                      \
    ARRAY(count, 1) /* number of measurements */                                                       \
    ARRAY(time, 1)  /* of the last one, since the first, in [s] */                                     \
    ARRAY(last_qd, n)                                                                                  \
    ARRAY(line, (D + 1) * C) /* last measurements, in a ring buffer */
#define SENSORS_ARRAYS(ARRAY)                                                                          \
    ARRAY(q, n)                                                                                        \
    ARRAY(qd, n)                                                                                       \
    ARRAY(tensions, m)                                                                                 \
    ARRAY(torques, n)                                                                                  \
    ARRAY(noise, C)                                                                                    \
    ARRAY(resolution, C)                                                                               \
    ARRAY(offset, C)                                                                                   \
    ARRAY(stuck, C)                                                                                    \
    ARRAY(compliance, m)                                                                               \
    ARRAY(seed, 1)                                                                                     \
    ARRAY(imu_rotation, 9 * i)                                                                         \
    ARRAY(imu_position, 3 * i)                                                                         \
    ARRAY(readings, C)                                                                                 \
    SENSORS_REMEMBERED(ARRAY)                                                                          \
    ARRAY(truth, C)                                                                                    \
    ARRAY(rates, variables)

struct sensors {
    core *core;
    size_t n, m, i, D, C, variables; /* C channels, delay D in measurements */
    const int32_t *imu_frame;
    SENSORS_ARRAYS(NAMED_MEMBER)
};

#define SENSORS_LENGTHS(c, imus, delay)                                                                \
    const size_t n = (size_t)(c)->blob.counts.dofs, m = (size_t)(c)->blob.counts.muscles;              \
    const size_t variables = (size_t)(c)->blob.counts.variables;                                       \
    const size_t i = (size_t)(imus), D = (size_t)(delay), C = 2 * m + 2 * n + 6 * i;

size_t sensors_size(const core *c, int32_t imus, int32_t delay)
{
    if (imus < 0 || imus > MAX_IMUS || delay < 0 || delay > MAX_DELAY) return 0;
    SENSORS_LENGTHS(c, imus, delay)
    size_t count = 0;
    SENSORS_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(sensors)) + count * sizeof(real);
}

sensors *sensors_open(core *c, int32_t imus, const int32_t *imu_frame, int32_t delay, void *memory)
{
    const size_t size = sensors_size(c, imus, delay);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    for (int32_t k = 0; k < imus; k++)
        if (imu_frame[k] < 0 || imu_frame[k] >= c->blob.counts.frames) return NULL;
    memset(memory, 0, size);
    SENSORS_LENGTHS(c, imus, delay)
    sensors *s = memory;
    s->core = c, s->imu_frame = imu_frame;
    s->n = n, s->m = m, s->i = i, s->D = D, s->C = C, s->variables = variables;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
    SENSORS_ARRAYS(NAMED_PLACE)
    for (size_t k = 0; k < C; k++) s->stuck[k] = INFINITY;
    return s;
}

real *sensors_array(sensors *s, const char *name, size_t *length)
{
    const size_t n = s->n, m = s->m, i = s->i, D = s->D, C = s->C, variables = s->variables;
    if (!strcmp(name, "remembered")) return *length = (size_t)(s->truth - s->count), s->count;
    SENSORS_ARRAYS(NAMED_FIND)
    return NULL;
}

void sensors_reset(sensors *s)
{
    memset(s->count, 0, (size_t)(s->truth - s->count) * sizeof(real));
}

static void read_units(sensors *s, real h, real *gyroscopes, real *accelerometers)
{
    core *c = s->core;
    if (!s->i) return;
    bodies_links(c);
    bodies_velocities(c, s->qd);
    for (size_t j = 0; j < s->n; j++) c->qdd[j] = s->count[0] > 0 ? (s->qd[j] - s->last_qd[j]) / h : 0;
    accelerate_frames(c, s->rates);
    for (size_t unit = 0; unit < s->i; unit++) {
        const int32_t frame = s->imu_frame[unit];
        real axes[9], r[3], force[3];
        multiply3(axes, c->rotation + 9 * frame, s->imu_rotation + 9 * unit);
        rotate3(r, c->rotation + 9 * frame, s->imu_position + 3 * unit);
        specific_force(c, frame, r, force);
        for (size_t k = 0; k < 3; k++) {
            const real along[3] = {axes[k], axes[3 + k], axes[6 + k]};
            gyroscopes[3 * unit + k] = dot3(along, c->spin + 3 * frame);
            accelerometers[3 * unit + k] = dot3(along, force);
        }
    }
}

/* Return the measurement of x by a channel; `last` is its previous measurement. */
static real read_channel(const sensors *s, size_t k, real x, real last)
{
    if (s->time[0] >= s->stuck[k] && s->count[0] > 0) return last;
    x += s->offset[k];
    if (s->noise[k] > 0) x += s->noise[k] * normal_number((uint64_t)s->seed[0], (uint64_t)s->count[0], k);
    return s->resolution[k] > 0 ? round(x / s->resolution[k]) * s->resolution[k] : x;
}

int sensors_read(sensors *s, real h)
{
    core *c = s->core;
    const size_t n = s->n, m = s->m, C = s->C, D = s->D;
    real *truth = s->truth;
    const int bad = core_move_checked(c, s->q, s->qd);
    if (bad) return bad;
    for (size_t k = 0; k < m; k++) truth[k] = c->lengths[k] - s->compliance[k] * s->tensions[k];
    memcpy(truth + m, s->tensions, m * sizeof(real));
    memcpy(truth + 2 * m, s->torques, n * sizeof(real));
    memcpy(truth + 2 * m + n, s->q, n * sizeof(real));
    read_units(s, h, truth + 2 * m + 2 * n, truth + 2 * m + 2 * n + 3 * s->i);
    if (s->count[0] > 0) s->time[0] += h;
    const uint64_t count = (uint64_t)s->count[0];
    real *now = s->line + (count % (D + 1)) * C;
    const real *last = s->line + ((count + D) % (D + 1)) * C;
    for (size_t k = 0; k < C; k++) now[k] = read_channel(s, k, truth[k], last[k]);
    memcpy(s->last_qd, s->qd, n * sizeof(real));
    /* during the delay, the first measurement is repeated */
    memcpy(s->readings, s->line + (count < D ? 0 : (count + 1) % (D + 1)) * C, C * sizeof(real));
    s->count[0] += 1;
    return 0;
}
