/* Backend: a Python model in the host's own Python. */
#ifndef PYTHON_IN_PROCESS_H
#define PYTHON_IN_PROCESS_H

#include "../model/model.h"

#include <stddef.h>

/* Where the model is to compute: the clock, then `count` values. */
struct python_memory {
    double *clock; /* NULL: memory that Python allocates */
    size_t count;
};

/* Whether this process is a Python with the package in this version; else why not. */
int python_in_process_fits(const char *version, struct text *why);

/* As backend_open. The memory must last as long as anything there looks at it. */
int python_in_process_open(struct model *model, const char *version,
                           const struct python_memory *memory, const char *resources,
                           struct text *error);

#endif
