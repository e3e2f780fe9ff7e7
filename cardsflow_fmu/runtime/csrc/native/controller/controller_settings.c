#include "controller_settings.h"

#include "predictive.h"

#include <math.h>
#include <string.h>

static const char DOES_NOT_FIT[] = "native.bin does not match its controller";

/* Return whether all indices are within their ranges. */
static int are_sound(const struct controller_settings *s, const struct native_robot *robot)
{
    return native_all_below(s->load_rows, s->of.loads.count, 3 * robot->tasks) &&
           native_all_below(s->task_rows, s->of.tasks.count, 3 * robot->tasks) &&
           native_all_below(s->state_order, s->of.states.count, robot->s) &&
           native_all_below(s->motors, s->of.motors.count, robot->n) &&
           native_all_below(s->commanded, s->of.commands.count, robot->m) &&
           (!s->nodes[0] || (s->plan_steps[0] >= 1 && s->plan_steps[0] <= 4096)) &&
           s->of.report.count == (s->of.tasks.count ? 5u : 4u) + (s->nodes[0] ? 3u : 0u) &&
           (s->of.valid.count == 0 || s->of.valid.count == 1) &&
           s->of.estimated_loads.count == s->of.valid.count * robot->n &&
           (s->of.modelled.count == 0 || s->of.modelled.count == robot->m);
}

int native_controller_settings(struct controller *data, const struct native_model *native, struct text *error)
{
    const struct native_robot *robot = &native->robot;
    const size_t n = robot->n;
    struct controller *c = data;
    struct controller_settings *s = &c->settings;
    if (controller_settings_read(s, native->file.settings, native->file.settings_size) || !are_sound(s, robot)) {
        text_set(error, DOES_NOT_FIT);
        return 1;
    }
    const size_t k = c->k = s->of.tasks.count, r = c->r = k ? k : n;
    const size_t a = c->a = robot->m + s->of.motors.count;
    CONTROLLER_GROUPS(NATIVE_PLACE)
    return 0;
}

/* Copy the settings that are arrays of the loop or of its law. Return nonzero if a name or a size is
   invalid. */
static int copy_arrays(const struct controller *c)
{
    const struct controller_settings *s = &c->settings;
    const char *name = s->array_names, *names_end = name + s->of.letters.count;
    const double *values = s->array_values, *values_end = values + s->of.numbers.count;
    while (name < names_end) {
        const char *end = memchr(name, 0, (size_t)(names_end - name));
        size_t length = 0;
        double *array = end ? native_predictive_array(c, name, &length) : NULL;
        if (end && !array)
            array = loop_array(c, name, &length);
        if (!array || length > (size_t)(values_end - values))
            return 1;
        memcpy(array, values, length * sizeof *values);
        name = end + 1;
        values += length;
    }
    return values != values_end;
}

int native_controller_fill(struct controller *c, const struct native_model *native, struct text *error)
{
    const struct controller_settings *s = &c->settings;
    const struct native_robot *robot = &native->robot;
    size_t length;
#define FIND(name) c->in_loop.name = loop_array(c, #name, &length);
    FOUND_ARRAYS(FIND)
#undef FIND
    if (copy_arrays(c)) {
        text_set(error, DOES_NOT_FIT);
        return 1;
    }
    if (c->k) {
        double *low = loop_array(c, "q_min", &length), *high = loop_array(c, "q_max", &length);
        for (size_t j = 0; j < robot->n; j++) {
            low[j] = s->dependent[j] != 0 ? -INFINITY : robot->lower[j];
            high[j] = s->dependent[j] != 0 ? INFINITY : robot->upper[j];
        }
    }
    return 0;
}
