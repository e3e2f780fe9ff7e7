/* Backend: a Python model in a separate worker process. */
#ifndef PYTHON_WORKER_H
#define PYTHON_WORKER_H

#include "../../model/model.h"
#include "../../model/port_table.h"

/* Open a model, as backend_open. */
int python_worker_open(struct model *model, const struct port_table *ports, const char *resources,
                       struct text *error);

#endif
