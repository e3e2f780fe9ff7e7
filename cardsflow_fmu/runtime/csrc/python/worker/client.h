/* Backend: a Python model in a worker process of its own. */
#ifndef PYTHON_WORKER_H
#define PYTHON_WORKER_H

#include "../../model/model.h"
#include "../../model/port_table.h"

/* As backend_open. */
int python_worker_open(struct model *model, const struct port_table *ports, const char *resources,
                       struct text *error);

#endif
