/* Messages to the logger of an FMI 2 host. */
#ifndef FMI2_LOG_H
#define FMI2_LOG_H

#include "../instance/log.h"
#include "fmi2_types.h"

struct fmi2_log {
    fmi2CallbackFunctions callbacks;
    char *instance_name;
};

/* A log_writer; the context is a struct fmi2_log. */
void fmi2_log_write(void *context, enum status status, const char *text);

#endif
