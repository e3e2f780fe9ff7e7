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

#endif
