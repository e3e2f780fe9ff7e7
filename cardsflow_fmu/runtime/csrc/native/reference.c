/* The reference as a native model: desired positions, velocities and accelerations out, and loads. */
#include "reference.h"

#include "../../../../sim_dart/csrc/math/elementary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SPLINES, ROSE, APPROACH, PART_KINDS };

struct reference {
    struct reference_settings settings;
    double time;
    size_t r;
    double *reference, *loads;
    const double *data[]; /* of each part */
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
    memset(c->reference, 0, 3 * c->r * sizeof(double));
    memcpy(c->reference, position, c->r * sizeof(double));
}

static void follow_splines(const struct reference *c, size_t part, double t)
{
    const size_t S = c->settings.part_segments[part], O = c->settings.part_powers[part], width = 3 * c->r;
    const double *times = c->data[part], *coefficients = times + S + 1, *first = coefficients + S * O * width;
    size_t segment = 0;
    if (t < 0 || t > c->settings.part_duration[part]) {
        rest_at(c, t < 0 ? first : first + c->r);
        return;
    }
    while (segment + 1 < S && t >= times[segment + 1])
        segment++;
    const double *table = coefficients + segment * O * width, since = t - times[segment];
    memset(c->reference, 0, width * sizeof(double));
    for (size_t k = O; k-- > 0;)
        for (size_t i = 0; i < width; i++)
            c->reference[i] = c->reference[i] * since + table[k * width + i];
}

/* y = c + R cos(k phi) u with u = cos(phi) e1 + sin(phi) e2, and v = u' */
static void follow_rose(const struct reference *c, size_t part, double t)
{
    const size_t r = c->r;
    const double *centre = c->data[part], *e1 = centre + r, *e2 = e1 + r;
    const double R = e2[r], k = e2[r + 1], last = e2[r + 2];
    double s[3], sn, cs, ksn, kcs;
    quintic(t, c->settings.part_duration[part], s);
    const double phi = last * s[0], phid = last * s[1], phidd = last * s[2];
    sine_cosine(phi, &sn, &cs);
    sine_cosine(k * phi, &ksn, &kcs);
    const double radius = R * kcs, radius_rate = -R * k * ksn;
    for (size_t i = 0; i < r; i++) {
        const double u = cs * e1[i] + sn * e2[i], v = cs * e2[i] - sn * e1[i];
        const double first = radius_rate * u + radius * v;
        const double second = -(k * k + 1) * radius * u + 2 * radius_rate * v;
        c->reference[i] = centre[i] + radius * u;
        c->reference[r + i] = first * phid;
        c->reference[2 * r + i] = second * phid * phid + first * phidd;
    }
}

static void follow_approach(const struct reference *c, size_t part, double t)
{
    const double *start = c->data[part], *way = start + c->r;
    double s[3];
    quintic(t, c->settings.part_duration[part], s);
    for (size_t i = 0; i < c->r; i++)
        for (size_t d = 0; d < 3; d++)
            c->reference[d * c->r + i] = s[d] * way[i] + (d ? 0 : start[i]);
}

static void go(struct reference *c, double time)
{
    static void (*const follow[PART_KINDS])(const struct reference *, size_t, double) = {
        follow_splines, follow_rose, follow_approach};
    const struct reference_settings *s = &c->settings;
    size_t part = 0;
    c->time = time;
    while (part + 1 < s->of.parts.count && time >= s->part_begin[part + 1])
        part++;
    follow[s->part_kind[part]](c, part, time - s->part_begin[part]);
    for (size_t i = 0; i < s->of.loads.count; i++)
        c->loads[i] = time >= s->load_begin[0] && time < s->load_end[0] ? s->load_forces[i] : 0;
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

static int has_nan(const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (isnan(values[i]))
            return 1;
    return 0;
}

/* Numbers that a part has in `data`; 0 where it is none. */
static uint64_t data_length(const struct reference_settings *s, size_t part, size_t r)
{
    const uint64_t S = s->part_segments[part], O = s->part_powers[part];
    if (s->part_kind[part] == SPLINES)
        return S >= 1 && S <= 1000000 && O <= 64 ? S + 1 + S * O * 3 * r + 2 * r : 0;
    if (s->part_kind[part] >= PART_KINDS || !(s->part_duration[part] > 0))
        return 0;
    return s->part_kind[part] == ROSE ? 3 * r + 3 : 2 * r;
}

/* Where each part's data begin; nonzero where the settings are not those of a reference. */
static int place_parts(struct reference *c)
{
    const struct reference_settings *s = &c->settings;
    const size_t parts = s->of.parts.count, r = s->of.reference.count / 3;
    uint64_t taken = 0;
    if (!parts || !r || r > 4096 || s->of.reference.count % 3 || has_nan(s->part_begin, parts) ||
        has_nan(s->part_duration, parts) || has_nan(s->data, s->of.numbers.count) || has_nan(s->load_begin, 1) ||
        has_nan(s->load_end, 1) || has_nan(s->load_forces, s->of.loads.count))
        return 1;
    c->r = r;
    for (size_t i = 0; i < parts; i++) {
        const uint64_t length = data_length(s, i, r);
        if (!length || length > s->of.numbers.count - taken)
            return 1;
        c->data[i] = s->data + taken;
        taken += length;
    }
    return taken != s->of.numbers.count;
}

int native_reference_open(struct model *model, struct native_model *native, struct text *error)
{
    struct reference_settings s;
    if (reference_settings_read(&s, native->file.settings, native->file.settings_size)) {
        text_set(error, "native.bin does not hold a reference");
        return 1;
    }
    struct reference *c = calloc(1, sizeof *c + s.of.parts.count * sizeof c->data[0]);
    if (!c) {
        text_set(error, "there is no memory for the model");
        return 1;
    }
    c->settings = s;
    const int failed = place_parts(c);
    if (failed)
        text_set(error, "native.bin does not hold a reference");
    if (failed || !(c->reference = native_values(native, s.of.reference, "reference", 3 * c->r, error)) ||
        !(c->loads = native_values(native, s.of.loads, "loads", ANY, error))) {
        free(c);
        return 1;
    }
    native->own = c;
    model->functions = &FUNCTIONS;
    return 0;
}
