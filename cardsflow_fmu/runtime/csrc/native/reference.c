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
    path_time_reset(&((struct reference *)native->data)->path);
    evaluate(native->data, native->clock[0]);
    return 0;
}

static int step(struct model *model)
{
    const struct native_model *native = model->backend;
    struct reference *c = native->data;
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

static size_t list_state(struct native_model *native, double **parts, size_t *sizes)
{
    struct reference *c = native->data;
    parts[0] = &c->time, sizes[0] = 1;
    parts[1] = &c->path.lag, sizes[1] = sizeof c->path / sizeof(double);
    return 2;
}

static int after_restore(struct model *model)
{
    struct reference *c = ((struct native_model *)model->backend)->data;
    evaluate(c, c->time);
    return 0;
}

static const struct native_memory MEMORY = {list_state, after_restore, free};

static const struct model_functions FUNCTIONS = {
    .initialize = initialize,
    .step = step,
    .reset = native_reset,
    .get_state = native_get_state,
    .set_state = native_set_state,
    .close = native_close_model,
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
    native->data = c;
    native->memory = &MEMORY;
    c->settings = s;
    if (place_parts(c)) {
        text_set(error, "native.bin does not hold a reference");
        return 1;
    }
    if (!(c->reference = native_values(native, s.of.reference, "reference", s.of.reference.count, error)) ||
        !(c->loads = native_values(native, s.of.loads, "loads", ANY, error)) ||
        !(c->speed = native_values(native, s.of.speed, "speed", ANY, error)) ||
        !(c->reached = native_values(native, s.of.reached, "reached", ANY, error)))
        return 1;
    model->functions = &FUNCTIONS;
    return 0;
}
