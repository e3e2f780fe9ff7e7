/* Data of an FMI 3 instance pointer. */
#ifndef FMI3_COMPONENT_H
#define FMI3_COMPONENT_H

#include "../instance/instance.h"
#include "fmi3_types.h"

struct fmi3_component {
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log_message;
    fmi3IntermediateUpdateCallback intermediate_update;
    fmi3Boolean may_return_early;
    double return_time; /* requested end of the step, or infinity */
    struct instance *instance;
};

/* Create an instance with these callbacks. Return NULL after a message in the log. */
fmi3Instance fmi3_open(const struct fmi3_component *callbacks, const char *token, const char *folder,
                       int logging_on, enum interface interface);

/* Return the instance, or NULL for a null pointer. */
struct instance *fmi3_instance(fmi3Instance instance);

/* A log_writer; the context is a struct fmi3_component. */
void fmi3_log_write(void *context, enum status status, const char *text);

/* Reject a call of an unsupported function. The state of the instance does not change. */
fmi3Status fmi3_reject(fmi3Instance instance, enum status status, const char *text);

/* Define a function of the standard without further arguments. */
#define FMI3_CALL(name, function)                                                                  \
    FMI3_Export fmi3Status name(fmi3Instance instance)                                             \
    {                                                                                              \
        return instance ? (fmi3Status)function(fmi3_instance(instance)) : fmi3Error;               \
    }

#endif
