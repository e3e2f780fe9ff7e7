/* The reference as a native model: desired positions, velocities and accelerations out, and loads.
 *
 * Values: rows (3 r), loads (3 p) where there is a disturbance; worker_timeout. There is no robot.
 *
 * Settings: r; number of loads, begin and end of the disturbance in s, the loads; number of parts; then, one
 * part behind the other, when it begins in s, its kind, its duration T in s, and
 *     0, splines:  number of segments S and of powers O; times at which they begin and the last ends
 *                  (S + 1); coefficients, lowest power first (S x O x 3 x r); first and last position (r each)
 *     1, rose:     centre, first and second axis (r each); radius R, petals k, largest angle phi
 *     2, approach: start and way (r each) */
#include "reference.h"

#include "../../../../sim_dart/csrc/math/elementary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SPLINES, ROSE, APPROACH, PARTS };

struct part {
    double begin, duration;
    int kind;
    size_t segments, powers;
    const double *data; /* what follows the numbers */
};

struct reference {
    double time;
    size_t r, loads, count;
    double begin, end;
    const double *forces;
    double *rows, *load;
    struct part parts[]; /* count of them */
};

/* ---------------------------------------------------------------------------------- evaluation */

/* s = 10 u^3 - 15 u^4 + 6 u^5, s' and s'', at rest before 0 and after T */
static void quintic(double t, double T, double s[3])
{
    const double u = t / T;
    s[0] = t >= T;
    s[1] = s[2] = 0;
    if (t <= 0 || t >= T)
        return;
    s[0] = u * u * u * (10 + u * (6 * u - 15));
    s[1] = 30 * u * u * (1 - u) * (1 - u) / T;
    s[2] = 60 * u * (1 - u) * (1 - 2 * u) / (T * T);
}

static void rest_at(const struct reference *c, const double *position)
{
    memset(c->rows, 0, 3 * c->r * sizeof(double));
    memcpy(c->rows, position, c->r * sizeof(double));
}

static void follow_splines(const struct reference *c, const struct part *part, double t)
{
    const size_t S = part->segments, O = part->powers, width = 3 * c->r;
    const double *times = part->data, *coefficients = times + S + 1, *first = coefficients + S * O * width;
    size_t segment = 0;
    if (t < 0 || t > part->duration) {
        rest_at(c, t < 0 ? first : first + c->r);
        return;
    }
    while (segment + 1 < S && t >= times[segment + 1])
        segment++;
    const double *table = coefficients + segment * O * width, since = t - times[segment];
    memset(c->rows, 0, width * sizeof(double));
    for (size_t k = O; k-- > 0;)
        for (size_t i = 0; i < width; i++)
            c->rows[i] = c->rows[i] * since + table[k * width + i];
}

/* y = c + R cos(k phi) u with u = cos(phi) e1 + sin(phi) e2, and v = u' */
static void follow_rose(const struct reference *c, const struct part *part, double t)
{
    const size_t r = c->r;
    const double *centre = part->data, *e1 = centre + r, *e2 = e1 + r;
    const double R = e2[r], k = e2[r + 1], last = e2[r + 2];
    double s[3], sn, cs, ksn, kcs;
    quintic(t, part->duration, s);
    const double phi = last * s[0], phid = last * s[1], phidd = last * s[2];
    sine_cosine(phi, &sn, &cs);
    sine_cosine(k * phi, &ksn, &kcs);
    const double radius = R * kcs, radius_rate = -R * k * ksn;
    for (size_t i = 0; i < r; i++) {
        const double u = cs * e1[i] + sn * e2[i], v = cs * e2[i] - sn * e1[i];
        const double first = radius_rate * u + radius * v;
        const double second = -(k * k + 1) * radius * u + 2 * radius_rate * v;
        c->rows[i] = centre[i] + radius * u;
        c->rows[r + i] = first * phid;
        c->rows[2 * r + i] = second * phid * phid + first * phidd;
    }
}

static void follow_approach(const struct reference *c, const struct part *part, double t)
{
    const double *start = part->data, *way = start + c->r;
    double s[3];
    quintic(t, part->duration, s);
    for (size_t i = 0; i < c->r; i++)
        for (size_t d = 0; d < 3; d++)
            c->rows[d * c->r + i] = s[d] * way[i] + (d ? 0 : start[i]);
}

static void go(struct reference *c, double time)
{
    size_t which = 0;
    c->time = time;
    while (which + 1 < c->count && time >= c->parts[which + 1].begin)
        which++;
    const struct part *part = &c->parts[which];
    const double t = time - part->begin;
    if (part->kind == SPLINES)
        follow_splines(c, part, t);
    else
        (part->kind == ROSE ? follow_rose : follow_approach)(c, part, t);
    for (size_t i = 0; i < c->loads; i++)
        c->load[i] = time >= c->begin && time < c->end ? c->forces[i] : 0;
}

/* ------------------------------------------------------------------------------------ the model */

static int initialize(struct model *model)
{
    const struct native_model *native = model->backend;
    go(native->own, native->clock[0]);
    return 0;
}

static int step(struct model *model)
{
    const struct native_model *native = model->backend;
    go(native->own, native->clock[0] + native->clock[1]);
    return 0;
}

static int get_state(struct model *model, void **bytes, size_t *size)
{
    const struct native_model *native = model->backend;
    const double *const parts[] = {&((const struct reference *)native->own)->time};
    const size_t sizes[] = {1};
    return native_save(parts, sizes, 1, bytes, size, &model->error);
}

static int set_state(struct model *model, const void *bytes, size_t size)
{
    struct native_model *native = model->backend;
    double time = 0;
    double *const parts[] = {&time};
    const size_t sizes[] = {1};
    if (native_restore(parts, sizes, 1, bytes, size, &model->error))
        return 1;
    go(native->own, time);
    return 0;
}

static void close_reference(struct model *model)
{
    struct native_model *native = model->backend;
    free(native->own);
    native_close(native);
}

static const struct model_functions FUNCTIONS = {
    .initialize = initialize,
    .step = step,
    .reset = native_reset,
    .get_state = get_state,
    .set_state = set_state,
    .close = close_reference,
};

/* ----------------------------------------------------------------------------------- opening it */

struct settings {
    const double *at;
    size_t left;
    int damaged;
};

static const double *take(struct settings *settings, size_t count)
{
    static const double none[4];
    if (settings->damaged || settings->left < count) {
        settings->damaged = 1;
        return none;
    }
    const double *taken = settings->at;
    settings->at += count;
    settings->left -= count;
    return taken;
}

/* A whole number within 0 to the largest; 0 if it is none. */
static size_t take_count(struct settings *settings, double largest)
{
    const double value = take(settings, 1)[0];
    if (!(value >= 0 && value <= largest) || value != floor(value))
        settings->damaged = 1;
    return settings->damaged ? 0 : (size_t)value;
}

static void take_part(struct settings *settings, struct part *part, size_t r)
{
    const double *head = take(settings, 1);
    part->begin = head[0];
    part->kind = (int)take_count(settings, PARTS - 1);
    part->duration = take(settings, 1)[0];
    if (part->kind == SPLINES) {
        part->segments = take_count(settings, 1e6);
        part->powers = take_count(settings, 64);
        settings->damaged |= part->segments == 0;
        part->data = take(settings, part->segments + 1);
        take(settings, part->segments * part->powers * 3 * r + 2 * r);
    } else {
        settings->damaged |= !(part->duration > 0);
        part->data = take(settings, part->kind == ROSE ? 3 * r + 3 : 2 * r);
    }
}

static int all_finite_or_infinite_end(const struct native_file *file)
{
    for (size_t i = 0; i < file->settings_count; i++)
        if (isnan(file->settings[i]))
            return 0;
    return 1;
}

int native_reference_open(struct model *model, struct native_model *native, struct text *error)
{
    struct settings settings = {native->file.settings, native->file.settings_count, 0};
    const size_t r = take_count(&settings, 4096), loads = take_count(&settings, 1e5);
    const double *times = take(&settings, 2), *forces = take(&settings, loads);
    const size_t count = take_count(&settings, 1e4);
    struct reference *c = calloc(1, sizeof *c + count * sizeof c->parts[0]);
    if (c)
        for (size_t i = 0; i < count; i++)
            take_part(&settings, &c->parts[i], r);
    if (!c || settings.damaged || settings.left || !r || !count || !all_finite_or_infinite_end(&native->file)) {
        text_set(error, "native.bin does not hold a reference");
        free(c);
        return 1;
    }
    if (!native_has_values(native, 3 * r + loads + 1, error)) {
        free(c);
        return 1;
    }
    c->r = r;
    c->loads = loads;
    c->count = count;
    c->begin = times[0];
    c->end = times[1];
    c->forces = forces;
    c->rows = native->values;
    c->load = c->rows + 3 * r;
    native->own = c;
    model->functions = &FUNCTIONS;
    return 0;
}
