/* The reference as a native model. Outputs: desired positions, velocities and accelerations, and loads. */
#include "reference.h"

#include "reference_parts.h"

#include <stdlib.h>

struct reference {
    struct reference_settings settings;
    double time;
    path_time path; /* constant without an input for the speed */
    double *reference, *loads, *speed, *reached;
    reference_part parts[];
};

static void evaluate(struct reference *c, double time)
{
    const struct reference_settings *s = &c->settings;
    const double at = time - c->path.lag;
    c->time = time;
    reference_evaluate(c->parts, s->part_begin, s->of.parts.count, 1, &at, c->reference);
    if (s->of.speed.count) {
        path_time_scale(&c->path, s->of.reference.count / 3, c->reference);
        c->reached[0] = at;
    }
    for (size_t i = 0; i < s->of.loads.count; i++)
        c->loads[i] = time >= s->load_begin[0] && time < s->load_end[0] ? s->load_forces[i] : 0;
}

/* ------------------------------------------------------------------------------------ the model */

static int initialize(struct model *model)
{
    const struct native_model *native = model->backend;
    path_time_reset(&((struct reference *)native->own)->path);
    evaluate(native->own, native->clock[0]);
    return 0;
}

static int step(struct model *model)
{
    const struct native_model *native = model->backend;
    struct reference *c = native->own;
    if (c->settings.of.speed.count) {
        if (!(c->speed[0] >= 0 && c->speed[0] <= 1)) {
            text_set(&model->error, "reference_speed must be from 0 to 1, not %.17g", c->speed[0]);
            return 1;
        }
        path_time_advance(&c->path, native->clock[1], c->speed[0], c->settings.ramp[0]);
    }
    evaluate(c, native->clock[0] + native->clock[1]);
    return 0;
}

static int get_state(struct model *model, void **bytes, size_t *size)
{
    const struct native_model *native = model->backend;
    const struct reference *c = native->own;
    const double *const parts[] = {&c->time, &c->path.lag};
    const size_t sizes[] = {1, sizeof c->path / sizeof(double)};
    return native_save(parts, sizes, 2, bytes, size, &model->error);
}

static int set_state(struct model *model, const void *bytes, size_t size)
{
    struct native_model *native = model->backend;
    struct reference *c = native->own;
    double *const parts[] = {&c->time, &c->path.lag};
    const size_t sizes[] = {1, sizeof c->path / sizeof(double)};
    if (native_restore(parts, sizes, 2, bytes, size, &model->error))
        return 1;
    evaluate(c, c->time);
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

/* ----------------------------------------------------------------------------------- opening */

/* Return nonzero if the settings are not those of a reference. */
static int place_parts(struct reference *c)
{
    const struct reference_settings *s = &c->settings;
    const struct native_parts parts = NATIVE_PARTS(s);
    return s->of.reference.count % 3 || native_has_nan(s->load_begin, 1) || native_has_nan(s->load_end, 1) ||
           native_has_nan(s->load_forces, s->of.loads.count) || native_has_nan(s->ramp, 1) ||
           s->of.reached.count != s->of.speed.count || s->of.speed.count > 1 ||
           native_parts_place(c->parts, &parts, s->of.reference.count / 3);
}

int native_reference_open(struct model *model, struct native_model *native, struct text *error)
{
    struct reference_settings s;
    if (reference_settings_read(&s, native->file.settings, native->file.settings_size)) {
        text_set(error, "native.bin does not hold a reference");
        return 1;
    }
    struct reference *c = calloc(1, sizeof *c + s.of.parts.count * sizeof c->parts[0]);
    if (!c) {
        text_set(error, "not enough memory for the model");
        return 1;
    }
    c->settings = s;
    const int failed = place_parts(c);
    if (failed)
        text_set(error, "native.bin does not hold a reference");
    if (failed || !(c->reference = native_values(native, s.of.reference, "reference", s.of.reference.count, error)) ||
        !(c->loads = native_values(native, s.of.loads, "loads", ANY, error)) ||
        !(c->speed = native_values(native, s.of.speed, "speed", ANY, error)) ||
        !(c->reached = native_values(native, s.of.reached, "reached", ANY, error))) {
        free(c);
        return 1;
    }
    native->own = c;
    model->functions = &FUNCTIONS;
    return 0;
}
