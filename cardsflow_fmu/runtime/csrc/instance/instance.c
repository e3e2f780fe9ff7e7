#include "instance.h"

#include "../model/backend.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double MAX_INTERNAL_STEPS = 100000; /* as for steps of a model */

enum status instance_fail(struct instance *instance, const char *format, ...)
{
    struct text text = {NULL};
    va_list arguments;
    va_start(arguments, format);
    text_set_list(&text, format, arguments);
    va_end(arguments);
    instance->life_cycle = FAILED;
    log_status(&instance->log, STATUS_ERROR, text_get(&text));
    text_free(&text);
    return STATUS_ERROR;
}

static const char *life_cycle_name(enum life_cycle life_cycle)
{
    switch (life_cycle) {
    case INSTANTIATED:
        return "instantiated";
    case INITIALIZATION_MODE:
        return "in initialization mode";
    case STEP_MODE:
        return "in step mode";
    case EVENT_MODE:
        return "in event mode";
    case CONTINUOUS_MODE:
        return "in continuous-time mode";
    case TERMINATED:
        return "terminated";
    case FAILED:
        break;
    }
    return "in error";
}

int instance_allows(struct instance *instance, const char *call, unsigned life_cycles)
{
    if (instance->life_cycle & life_cycles)
        return 1;
    if (instance->life_cycle != FAILED) /* a failure was reported when it occurred */
        instance_fail(instance, "%s: out of order, the instance is %s", call,
                      life_cycle_name(instance->life_cycle));
    return 0;
}

/* Compute outputs, derivatives and event indicators if states or inputs were set. Without model exchange, do
 * nothing. States at which the model cannot be evaluated result in STATUS_DISCARD, so that a solver can use a
 * smaller step. */
static enum status evaluate(struct instance *instance)
{
    const struct continuous_functions *functions = instance->model.continuous.functions;
    if (!functions || !instance->evaluation_is_due)
        return STATUS_OK;
    if (functions->evaluate(&instance->model)) {
        log_status(&instance->log, STATUS_DISCARD, text_get(&instance->model.error));
        return STATUS_DISCARD;
    }
    instance->evaluation_is_due = 0;
    return STATUS_OK;
}

enum status instance_update(struct instance *instance)
{
    if (!instance->initialization_is_due)
        return evaluate(instance);
    instance->model.clock[0] = instance->start_time;
    instance->model.clock[1] = 0;
    if (instance->model.functions->initialize(&instance->model))
        return instance_fail(instance, "initialization: %s", text_get(&instance->model.error));
    instance->initialization_is_due = instance->evaluation_is_due = 0;
    return STATUS_OK;
}

static void return_to_start(struct instance *instance)
{
    for (size_t i = 0; i < instance->ports.count; i++)
        instance->model.values[i] = instance->ports.ports[i].start;
    instance->life_cycle = INSTANTIATED;
    instance->is_set_up = 0;
    instance->initialization_is_due = 1;
    instance->evaluation_is_due = 0;
    instance->start_time = instance->time = 0;
    instance->stop_time = INFINITY;
}

static int open_table(struct instance *instance, const char *guid, const char *folder,
                      struct text *error)
{
    if (port_table_read(&instance->ports, folder, error))
        return 1;
    if (guid && strcmp(guid, instance->ports.guid) == 0)
        return 0;
    text_set(error, "the host's GUID %s is not this FMU's, which is %s: unpack the FMU again",
             guid ? guid : "(none)", instance->ports.guid);
    return 1;
}

static int open_files(struct instance *instance, const char *guid, const char *folder,
                      enum interface interface, struct text *error)
{
    if (open_table(instance, guid, folder, error) ||
        backend_open(&instance->model, &instance->ports, folder, error))
        return 1;
    const int is_continuous = instance->model.continuous.functions != NULL;
    if (is_continuous == (interface == MODEL_EXCHANGE))
        return 0;
    text_set(error, is_continuous ? "this FMU is for model exchange, not for co-simulation"
                                  : "this FMU is for co-simulation, not for model exchange");
    instance->model.functions->close(&instance->model);
    return 1;
}

struct instance *instance_open(const struct log *log, const char *guid, const char *folder,
                               enum interface interface)
{
    struct text error = {NULL};
    struct instance *instance = calloc(1, sizeof *instance);
    if (!instance || open_files(instance, guid, folder, interface, &error)) {
        log_status(log, STATUS_ERROR, text_get(&error));
        text_free(&error);
        if (instance)
            port_table_free(&instance->ports);
        free(instance);
        return NULL;
    }
    instance->log = *log;
    return_to_start(instance);
    log_status(log, STATUS_OK, "instantiated");
    return instance;
}

void instance_close(struct instance *instance)
{
    instance->model.functions->close(&instance->model);
    text_free(&instance->model.error);
    port_table_free(&instance->ports);
    free(instance);
}

enum status instance_set_up(struct instance *instance, const char *call, double start_time,
                            double stop_time)
{
    if (!instance_allows(instance, call, INSTANTIATED))
        return STATUS_ERROR;
    if (!isfinite(start_time) || !(stop_time >= start_time))
        return instance_fail(instance, "%s: invalid time from %.12g s to %.12g s", call, start_time,
                             stop_time);
    instance->is_set_up = 1;
    instance->start_time = instance->time = start_time;
    instance->stop_time = stop_time;
    return STATUS_OK;
}

enum status instance_enter_initialization_mode(struct instance *instance)
{
    if (!instance_allows(instance, "enterInitializationMode", INSTANTIATED))
        return STATUS_ERROR;
    if (!instance->is_set_up)
        return instance_fail(instance,
                             "enterInitializationMode: out of order; call setupExperiment first");
    instance->life_cycle = INITIALIZATION_MODE;
    instance->initialization_is_due = 1;
    return STATUS_OK;
}

enum status instance_exit_initialization_mode(struct instance *instance)
{
    if (!instance_allows(instance, "exitInitializationMode", INITIALIZATION_MODE) ||
        instance_update(instance) != STATUS_OK)
        return STATUS_ERROR;
    instance->life_cycle = instance->model.continuous.functions ? EVENT_MODE : STEP_MODE;
    log_status(&instance->log, STATUS_OK, "initialized");
    return STATUS_OK;
}

/* Return the tolerance for rounding errors of hosts that compute their own time, relative to the step. */
static double time_tolerance(double time, double step)
{
    return 1e-6 * step + 16 * DBL_EPSILON * fabs(time);
}

static enum status check_step(struct instance *instance, double time, double step)
{
    if (!isfinite(time) || !isfinite(step) || step <= 0)
        return instance_fail(instance, "doStep: invalid step of %.12g s at %.12g s", step, time);
    double tolerance = time_tolerance(time, step);
    if (!(fabs(time - instance->time) <= tolerance))
        return instance_fail(instance,
                             "doStep: the step starts at %.12g s, but the last step ended at %.12g s",
                             time, instance->time);
    if (time + step > instance->stop_time + tolerance)
        return instance_fail(instance,
                             "doStep: the step ends at %.12g s, after the stop time %.12g s",
                             time + step, instance->stop_time);
    return STATUS_OK;
}

/* Return the number of internal steps in a step: 1 for models without them and for impossible lengths. */
static size_t internal_steps(const struct model *model, double step)
{
    const double ratio = model->internal_step ? step / *model->internal_step : 1, steps = floor(ratio + 0.5);
    return steps > 1 && steps <= MAX_INTERNAL_STEPS && fabs(ratio - steps) <= 1e-9 * steps ? (size_t)steps : 1;
}

static enum status advance(struct instance *instance, double time, double step)
{
    instance->model.clock[0] = time;
    instance->model.clock[1] = step;
    if (!instance->model.functions->step(&instance->model))
        return STATUS_OK;
    if (instance->model.clock[1] == 0) { /* nothing has changed */
        log_status(&instance->log, STATUS_DISCARD, text_get(&instance->model.error));
        return STATUS_DISCARD;
    }
    return instance_fail(instance, "doStep at %.12g s: %s", time, text_get(&instance->model.error));
}

enum status instance_step(struct instance *instance, double time, double step, const struct step_observer *observer)
{
    if (!instance_allows(instance, "doStep", STEP_MODE) ||
        check_step(instance, time, step) != STATUS_OK)
        return STATUS_ERROR;
    const size_t count = observer ? internal_steps(&instance->model, step) : 1;
    const double length = step / (double)count, end = time + step;
    for (size_t k = 0; k < count; k++) {
        const enum status status = advance(instance, time + (double)k * length, length);
        if (status != STATUS_OK)
            return status;
        instance->time = k + 1 < count ? time + (double)(k + 1) * length : end;
        const double next = k + 2 < count ? time + (double)(k + 2) * length : end;
        if (observer && observer->completed(observer->context, instance->time, next))
            break;
    }
    return STATUS_OK;
}

/* Terminate. A failed instance also releases its devices, for safety. */
enum status instance_terminate(struct instance *instance)
{
    int (*terminate)(struct model *) = instance->model.functions->terminate;
    int failed = terminate && (instance->life_cycle & (RUNNING | FAILED)) &&
                 terminate(&instance->model);
    if (!instance_allows(instance, "terminate", RUNNING))
        return STATUS_ERROR;
    if (failed)
        return instance_fail(instance, "terminate: %s", text_get(&instance->model.error));
    instance->life_cycle = TERMINATED;
    log_status(&instance->log, STATUS_OK, "terminated");
    return STATUS_OK;
}

enum status instance_reset(struct instance *instance)
{
    if (instance->model.functions->reset(&instance->model))
        return instance_fail(instance, "reset: %s", text_get(&instance->model.error));
    return_to_start(instance);
    log_status(&instance->log, STATUS_OK, "reset");
    return STATUS_OK;
}
