/* Backend: a Python model in the host's own Python. */
#ifndef PYTHON_IN_PROCESS_H
#define PYTHON_IN_PROCESS_H

#include "model.h"
#include "port_table.h"

/* As backend_open. */
int python_in_process_open(struct model *model, const struct port_table *ports,
                           const char *resources, struct text *error);

#endif
