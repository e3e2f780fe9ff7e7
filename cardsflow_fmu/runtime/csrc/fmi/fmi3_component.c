#include "fmi3_component.h"

#include "../platform/utf8.h"

#include <stdlib.h>

static struct instance *open_instance(struct fmi3_component *component, const char *token, const char *folder,
                                      int logging_on, enum interface interface)
{
    struct log log = {fmi3_log_write, component, logging_on};
    if (folder)
        return instance_open(&log, token, folder, interface);
    log_status(&log, STATUS_ERROR, "this FMU needs the path of its resources");
    return NULL;
}

fmi3Instance fmi3_open(const struct fmi3_component *callbacks, const char *token, const char *folder,
                       int logging_on, enum interface interface)
{
    struct fmi3_component *component = malloc(sizeof *component);
    if (!component)
        return NULL;
    *component = *callbacks;
    component->instance = open_instance(component, token, folder, logging_on, interface);
    if (!component->instance) {
        free(component);
        return NULL;
    }
    component->instance->has_time_variable = 1;
    return component;
}

struct instance *fmi3_instance(fmi3Instance instance)
{
    return instance ? ((struct fmi3_component *)instance)->instance : NULL;
}

/* Replace bytes that are not UTF-8 by question marks. */
static void clean(char *text)
{
    for (; *text; text += utf8_next(text))
        if (utf8_length(text) == 0)
            *text = '?';
}

void fmi3_log_write(void *context, enum status status, const char *text)
{
    const struct fmi3_component *component = context;
    char *message = component->log_message ? text_copy(text) : NULL;
    if (!message)
        return;
    clean(message);
    component->log_message(component->environment, (fmi3Status)status, log_category(status),
                           message);
    free(message);
}

fmi3Status fmi3_reject(fmi3Instance instance, enum status status, const char *text)
{
    if (instance)
        log_status(&fmi3_instance(instance)->log, status, text);
    return instance ? (fmi3Status)status : fmi3Error;
}
