/* The reference as a native model. Outputs: desired positions, velocities and accelerations, and loads. */
#include "model.h"
#include "reference_parts.h"

#include <stdlib.h>

struct reference {
    struct reference_settings settings;
    double time;
    path_time path; /* constant without an input for the speed */
    double *reference, *loads, *speed, *reached;
    reference_part *parts;
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

static void release(void *data)
{
    struct reference *c = data;
    free(c->parts);
    free(c);
}

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

static int open_reference(struct model *model, struct native_model *native, struct text *error)
{
    struct reference *data = native->data;
    struct reference_settings *s = &data->settings;
    if (reference_settings_read(s, native->file.settings, native->file.settings_size)) {
        text_set(error, "native.bin does not hold a reference");
        return 1;
    }
    data->parts = calloc(s->of.parts.count + 1, sizeof *data->parts);
    if (!data->parts || place_parts(data)) {
        text_set(error, data->parts ? "native.bin does not hold a reference" : "not enough memory for the model");
        return 1;
    }
    const size_t r = s->of.reference.count / 3;
    REFERENCE_GROUPS(NATIVE_PLACE)
    (void)model;
    return 0;
}

const struct native_functions native_reference = {
    .model = {.initialize = initialize, .step = step, NATIVE_FUNCTIONS},
    .size = sizeof(struct reference),
    .open = open_reference,
    .list_state = list_state,
    .after_restore = after_restore,
    .release = release,
};
