#include "opened_model.h"

#include "../native/layout.h"
#include "../native/model.h"
#include "../native/open.h"

#include <stdlib.h>
#include <string.h>

const char *native_model_layout(int32_t kind)
{
    return kind >= 0 && kind < NATIVE_KINDS ? native_layout((enum native_kind)kind) : NULL;
}

uint32_t native_model_layout_hash(int32_t kind)
{
    return native_layout_hash((enum native_kind)kind);
}

static void set_message(char *message, size_t capacity, const char *text)
{
    if (!capacity)
        return;
    strncpy(message, text, capacity - 1);
    message[capacity - 1] = '\0';
}

struct opened_model *native_model_open(const void *file, size_t size, const void *ports, size_t ports_size,
                                       double *values, char *message, size_t capacity)
{
    struct text error = {NULL};
    struct opened_model *opened = calloc(1, sizeof *opened);
    if (!opened)
        text_set(&error, "not enough memory for the model");
    if (opened && !port_table_copy(&opened->ports, ports, ports_size, &error) &&
        !native_open_bytes(&opened->model, &opened->ports, file, size, values, &error))
        return opened;
    set_message(message, capacity, text_get(&error));
    text_free(&error);
    if (opened)
        port_table_free(&opened->ports);
    free(opened);
    return NULL;
}

void native_model_close(struct opened_model *opened)
{
    opened->model.functions->close(&opened->model);
    text_free(&opened->model.error);
    port_table_free(&opened->ports);
    free(opened->state);
    free(opened);
}

static struct model *at(struct opened_model *opened, double t, double h)
{
    opened->model.clock[0] = t;
    opened->model.clock[1] = h;
    return &opened->model;
}

int native_model_initialize(struct opened_model *opened, double t)
{
    return opened->model.functions->initialize(at(opened, t, 0));
}

int native_model_step(struct opened_model *opened, double t, double h)
{
    if (!opened->model.functions->step(at(opened, t, h)))
        return 0;
    return opened->model.clock[1] == 0 ? NATIVE_MODEL_DISCARDED : 1;
}

int native_model_get_state(struct opened_model *opened, void **bytes, size_t *size)
{
    free(opened->state);
    opened->state = NULL;
    const int failed = opened->model.functions->get_state(&opened->model, &opened->state, size);
    *bytes = opened->state;
    return failed;
}

int native_model_set_state(struct opened_model *opened, const void *bytes, size_t size)
{
    return opened->model.functions->set_state(&opened->model, bytes, size);
}

int native_model_use(struct opened_model *opened, const control_law *law, const struct muscle_functions *muscles)
{
    return native_controller_use(&opened->model, law, muscles);
}

static core *core_of(const struct opened_model *opened)
{
    const struct native_model *native = opened->model.backend;
    return native->robot.core;
}

double *native_model_array(struct opened_model *opened, const char *name, size_t *length)
{
    double *array = native_controller_array(&opened->model, name, length);
    return array || !core_of(opened) ? array : core_array(core_of(opened), name, length);
}

int32_t native_model_lines(struct opened_model *opened, int32_t *sizes, double *points, int32_t capacity)
{
    return core_of(opened) ? core_lines(core_of(opened), sizes, points, capacity) : 0;
}

const char *native_model_message(const struct opened_model *opened)
{
    return text_get(&opened->model.error);
}
