/* Opening a native model. */
#ifndef NATIVE_OPEN_H
#define NATIVE_OPEN_H

#include "../model/model.h"
#include "../model/port_table.h"

/* Opens the model whose files are in the folder `resources`, in this process and without any Python. 0, or
 * nonzero with a message; the model needs no close then. */
int native_open(struct model *model, const struct port_table *ports, const char *resources,
                struct text *error);

/* The same of the contents of native.bin; the variables are the caller's `values`. */
int native_open_bytes(struct model *model, const struct port_table *ports, const void *bytes, size_t size,
                      double *values, struct text *error);

#endif
