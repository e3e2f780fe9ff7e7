#include "variables.h"

#include <math.h>

static const char *const TYPE_NAMES[PORT_TYPES] = {"real", "boolean"};

/* The variable, or NULL after the instance has failed. */
static const struct port *find(struct instance *instance, const char *call, unsigned reference,
                               enum port_type type)
{
    if (reference >= instance->ports.count) {
        instance_fail(instance, "%s: there is no value reference %u; the last one is %ld", call,
                      reference, (long)instance->ports.count - 1);
        return NULL;
    }
    const struct port *port = &instance->ports.ports[reference];
    if (port->type != type) {
        instance_fail(instance, "%s: %s (value reference %u) is a %s variable", call, port->name,
                      reference, TYPE_NAMES[port->type]);
        return NULL;
    }
    return port;
}

static unsigned settable_in(const struct port *port)
{
    if (port->causality == CAUSALITY_OUTPUT)
        return 0;
    if (port->variability == VARIABILITY_FIXED)
        return INSTANTIATED | INITIALIZATION_MODE;
    return INSTANTIATED | INITIALIZATION_MODE | STEP_MODE;
}

/* Whether the variable may be set now; else the instance has failed. */
static int may_set(struct instance *instance, const char *call, unsigned reference,
                   enum port_type type)
{
    const struct port *port = find(instance, call, reference, type);
    if (!port)
        return 0;
    if (settable_in(port) & instance->life_cycle)
        return 1;
    const char *why = port->causality == CAUSALITY_OUTPUT
                          ? "is an output and cannot be set"
                          : "is a fixed parameter and cannot be set after the initialization";
    instance_fail(instance, "%s: %s %s", call, port->name, why);
    return 0;
}

static int begin_get(struct instance *instance, const char *call)
{
    return instance_allows(instance, call, INITIALIZATION_MODE | STEP_MODE | TERMINATED) &&
           instance_update(instance) == STATUS_OK;
}

static int begin_set(struct instance *instance, const char *call)
{
    return instance_allows(instance, call, INSTANTIATED | INITIALIZATION_MODE | STEP_MODE);
}

static void end_set(struct instance *instance)
{
    if (instance->life_cycle != STEP_MODE)
        instance->initialization_is_due = 1;
}

enum status get_reals(struct instance *instance, const unsigned *references, size_t count,
                      double *values)
{
    if (!begin_get(instance, "getReal"))
        return STATUS_ERROR;
    for (size_t i = 0; i < count; i++) {
        if (!find(instance, "getReal", references[i], PORT_REAL))
            return STATUS_ERROR;
        values[i] = instance->model.values[references[i]];
    }
    return STATUS_OK;
}

enum status get_booleans(struct instance *instance, const unsigned *references, size_t count,
                         int *values)
{
    if (!begin_get(instance, "getBoolean"))
        return STATUS_ERROR;
    for (size_t i = 0; i < count; i++) {
        if (!find(instance, "getBoolean", references[i], PORT_BOOLEAN))
            return STATUS_ERROR;
        values[i] = instance->model.values[references[i]] != 0;
    }
    return STATUS_OK;
}

enum status set_reals(struct instance *instance, const unsigned *references, size_t count,
                      const double *values)
{
    if (!begin_set(instance, "setReal"))
        return STATUS_ERROR;
    for (size_t i = 0; i < count; i++) {
        if (!may_set(instance, "setReal", references[i], PORT_REAL))
            return STATUS_ERROR;
        if (!isfinite(values[i]))
            return instance_fail(instance, "setReal: %s cannot be %g",
                                 instance->ports.ports[references[i]].name, values[i]);
        instance->model.values[references[i]] = values[i];
    }
    end_set(instance);
    return STATUS_OK;
}

enum status set_booleans(struct instance *instance, const unsigned *references, size_t count,
                         const int *values)
{
    if (!begin_set(instance, "setBoolean"))
        return STATUS_ERROR;
    for (size_t i = 0; i < count; i++) {
        if (!may_set(instance, "setBoolean", references[i], PORT_BOOLEAN))
            return STATUS_ERROR;
        instance->model.values[references[i]] = values[i] != 0;
    }
    end_set(instance);
    return STATUS_OK;
}
