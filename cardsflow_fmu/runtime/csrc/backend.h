/* The choice of what runs the model of an FMU. */
#ifndef BACKEND_H
#define BACKEND_H

#include "model.h"
#include "port_table.h"

/* Opens the model whose files are in the folder `resources`. 0, or nonzero with a message; the model
 * needs no close then. */
int backend_open(struct model *model, const struct port_table *ports, const char *resources,
                 struct text *error);

#endif
