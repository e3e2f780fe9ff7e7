/* Selection of the backend that runs the model of an FMU. */
#ifndef BACKEND_H
#define BACKEND_H

#include "model.h"
#include "port_table.h"

/* Open the model with its files in the folder `resources`: a native model, if native.bin exists, without
 * Python; otherwise in this process, if it is Python with the package in the correct version; otherwise in a
 * worker process. The environment variable CARDSFLOW_FMU_HOST selects `in-process` or `worker`. Return 0, or
 * nonzero with a message; in this case the model needs no close. */
int backend_open(struct model *model, const struct port_table *ports, const char *resources,
                 struct text *error);

#endif
