/* Opening a native model. */
#ifndef NATIVE_OPEN_H
#define NATIVE_OPEN_H

#include "../model/model.h"
#include "../model/port_table.h"

/* Open the model with its files in the folder `resources`, in this process and without Python. Return 0, or
 * nonzero with a message; in this case the model needs no close. */
int native_open(struct model *model, const struct port_table *ports, const char *resources,
                struct text *error);

/* Open a model from the contents of native.bin; the variables are in `values` of the caller. */
int native_open_bytes(struct model *model, const struct port_table *ports, const void *bytes, size_t size,
                      double *values, struct text *error);

#endif
