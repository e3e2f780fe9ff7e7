/* Backend: a Python model in the Python of the host. */
#ifndef PYTHON_IN_PROCESS_H
#define PYTHON_IN_PROCESS_H

#include "../model/model.h"

#include <stddef.h>

/* Memory of the model: the clock, then `count` values. */
struct python_memory {
    double *clock; /* NULL: memory that Python allocates */
    size_t count;
};

/* Return whether this process is Python with the package in this version; otherwise write the reason. */
int python_in_process_fits(const char *version, struct text *why);

/* Open a model, as backend_open. The memory must outlive all users of it. */
int python_in_process_open(struct model *model, const char *version,
                           const struct python_memory *memory, const char *resources,
                           struct text *error);

#endif
