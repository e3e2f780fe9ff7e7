#include "variables.h"

#include <math.h>
#include <stdbool.h>

static const char *const TYPE_NAMES[PORT_TYPES] = {"real", "boolean"};

/* Return the variable, or NULL after the instance has failed. */
static const struct port *find(struct instance *instance, const char *call, uint32_t reference,
                               enum port_type type)
{
    if (reference >= instance->ports.count) {
        instance_fail(instance, "%s: unknown value reference %lu; the last one is %ld", call,
                      (unsigned long)reference, (long)instance->ports.count - 1);
        return NULL;
    }
    const struct port *port = &instance->ports.ports[reference];
    if (port->size == 0) {
        instance_fail(instance, "%s: value reference %lu is within the array %s", call,
                      (unsigned long)reference, port->name);
        return NULL;
    }
    if (port->type != type) {
        instance_fail(instance, "%s: %s (value reference %lu) is a %s variable", call, port->name,
                      (unsigned long)reference, TYPE_NAMES[port->type]);
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
    return INSTANTIATED | INITIALIZATION_MODE | RUNNING;
}

/* Return whether the variable may be set now; otherwise the instance fails. */
static int may_set(struct instance *instance, const char *call, uint32_t reference,
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
    return instance_allows(instance, call, INITIALIZATION_MODE | RUNNING | TERMINATED) &&
           instance_update(instance) == STATUS_OK;
}

static int begin_set(struct instance *instance, const char *call)
{
    return instance_allows(instance, call, INSTANTIATED | INITIALIZATION_MODE | RUNNING);
}

static void end_set(struct instance *instance)
{
    if (!(instance->life_cycle & RUNNING))
        instance->initialization_is_due = 1;
    instance->evaluation_is_due = 1;
}

/* Return whether `left` values of the host are enough for a variable of this size. */
static int has_room(struct instance *instance, const char *call, const struct port *port,
                    size_t left)
{
    if (port->size <= left)
        return 1;
    instance_fail(instance, "%s: %s requires %lu values, %lu remain", call, port->name,
                  (unsigned long)port->size, (unsigned long)left);
    return 0;
}

/* Check that no values of the host remain after the last variable. */
static enum status check_left(struct instance *instance, const char *call, size_t left)
{
    if (left == 0)
        return STATUS_OK;
    return instance_fail(instance, "%s: %lu values too many for the variables", call,
                         (unsigned long)left);
}

/* Copy values to those of the host, from `at` on. */
static void write_values(void *host, size_t at, enum representation as, const double *values,
                         size_t count)
{
    switch (as) {
    case AS_DOUBLE:
        for (size_t i = 0; i < count; i++)
            ((double *)host)[at + i] = values[i];
        break;
    case AS_INT:
        for (size_t i = 0; i < count; i++)
            ((int *)host)[at + i] = values[i] != 0;
        break;
    case AS_BOOL:
        for (size_t i = 0; i < count; i++)
            ((bool *)host)[at + i] = values[i] != 0;
        break;
    }
}

/* Copy values of the host, from `at` on; they must be finite. */
static void read_values(const void *host, size_t at, enum representation as, double *values,
                        size_t count)
{
    switch (as) {
    case AS_DOUBLE:
        for (size_t i = 0; i < count; i++)
            values[i] = ((const double *)host)[at + i];
        break;
    case AS_INT:
        for (size_t i = 0; i < count; i++)
            values[i] = ((const int *)host)[at + i] != 0;
        break;
    case AS_BOOL:
        for (size_t i = 0; i < count; i++)
            values[i] = ((const bool *)host)[at + i];
        break;
    }
}

/* Return whether the values of the host, from `at` on, are finite; otherwise the instance fails. */
static int are_finite(struct instance *instance, const struct access *access, const char *name,
                      const void *host, size_t at, size_t count)
{
    const double *values = (const double *)host + at;
    if (access->representation != AS_DOUBLE)
        return 1;
    for (size_t i = 0; i < count; i++)
        if (!isfinite(values[i])) {
            instance_fail(instance, "%s: %s cannot be %g", access->call, name, values[i]);
            return 0;
        }
    return 1;
}

/* Return whether this is the independent variable, whose reference is the first after those of the values. */
static int is_time(const struct instance *instance, uint32_t reference, enum port_type type)
{
    return reference == instance->ports.count && type == PORT_REAL && instance->has_time_variable;
}

/* Get a variable. Return its number of values; 0 after the instance has failed. */
static size_t get_variable(struct instance *instance, const struct access *access,
                           uint32_t reference, void *values, size_t at, size_t left)
{
    if (left > 0 && is_time(instance, reference, access->type)) {
        write_values(values, at, access->representation, &instance->time, 1);
        return 1;
    }
    const struct port *port = find(instance, access->call, reference, access->type);
    if (!port || !has_room(instance, access->call, port, left))
        return 0;
    write_values(values, at, access->representation, instance->model.values + reference,
                 port->size);
    return port->size;
}

enum status get_variables(struct instance *instance, const struct access *access,
                          struct variables variables, void *values)
{
    size_t at = 0;
    if (!begin_get(instance, access->call))
        return STATUS_ERROR;
    for (size_t i = 0; i < variables.count; i++) {
        size_t size = get_variable(instance, access, variables.references[i], values, at,
                                   variables.value_count - at);
        if (size == 0)
            return STATUS_ERROR;
        at += size;
    }
    return check_left(instance, access->call, variables.value_count - at);
}

static size_t set_variable(struct instance *instance, const struct access *access,
                           uint32_t reference, const void *values, size_t at, size_t left)
{
    if (!may_set(instance, access->call, reference, access->type))
        return 0;
    const struct port *port = &instance->ports.ports[reference];
    if (!has_room(instance, access->call, port, left))
        return 0;
    if (!are_finite(instance, access, port->name, values, at, port->size))
        return 0;
    read_values(values, at, access->representation, instance->model.values + reference,
                port->size);
    return port->size;
}

enum status set_variables(struct instance *instance, const struct access *access,
                          struct variables variables, const void *values)
{
    size_t at = 0;
    if (!begin_set(instance, access->call))
        return STATUS_ERROR;
    for (size_t i = 0; i < variables.count; i++) {
        size_t size = set_variable(instance, access, variables.references[i], values, at,
                                   variables.value_count - at);
        if (size == 0)
            return STATUS_ERROR;
        at += size;
    }
    if (check_left(instance, access->call, variables.value_count - at) != STATUS_OK)
        return STATUS_ERROR;
    end_set(instance);
    return STATUS_OK;
}
