/* Data of an FMI 2 component pointer. */
#ifndef FMI2_COMPONENT_H
#define FMI2_COMPONENT_H

#include "../instance/instance.h"
#include "fmi2_log.h"

struct component {
    struct fmi2_log log;
    struct instance *instance;
};

static inline struct instance *instance_of(fmi2Component c)
{
    return ((struct component *)c)->instance;
}

/* Define a function of the standard without further arguments. */
#define FMI2_CALL(name, function)                                                                  \
    FMI2_Export fmi2Status name(fmi2Component c)                                                   \
    {                                                                                              \
        return c ? (fmi2Status)function(instance_of(c)) : fmi2Error;                               \
    }

#endif
