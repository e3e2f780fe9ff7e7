/* The choice of what runs the model of an FMU. */
#ifndef BACKEND_H
#define BACKEND_H

#include "model.h"
#include "port_table.h"

/* Opens the model whose files are in the folder `resources`: a native one, if there is a native.bin,
 * without any Python; else in this process if that is a Python
 * with the package in the right version, else in a worker process. The environment variable
 * CARDSFLOW_FMU_HOST forces the one, `in-process`, or the other, `worker`. 0, or nonzero with a
 * message; the model needs no close then. */
int backend_open(struct model *model, const struct port_table *ports, const char *resources,
                 struct text *error);

#endif
