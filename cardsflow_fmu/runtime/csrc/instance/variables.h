/* Access to the variables of an instance. */
#ifndef VARIABLES_H
#define VARIABLES_H

#include "instance.h"

#include <stddef.h>
#include <stdint.h>

/* C type of the values of the host. */
enum representation { AS_DOUBLE, AS_INT, AS_BOOL };

/* A kind of access: name of the FMI function, type of the variables, and type of the values of the host. */
struct access {
    const char *call;
    enum port_type type;
    enum representation representation;
};

/* The variables to get or set, and the values of the host, variable after variable. */
struct variables {
    const uint32_t *references;
    size_t count;
    size_t value_count;
};

enum status get_variables(struct instance *instance, const struct access *access,
                          struct variables variables, void *values);
enum status set_variables(struct instance *instance, const struct access *access,
                          struct variables variables, const void *values);

#endif
