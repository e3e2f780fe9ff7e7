/* The controller as a native model. */
#ifndef NATIVE_CONTROLLER_H
#define NATIVE_CONTROLLER_H

#include "../../../../../controllers/csrc/loop/control_loop.h"
#include "../model.h"
#include "muscles.h"

/* Set a custom law, and muscle laws outside of C, of a controller. Return nonzero if the model is not a
   controller. */
int native_controller_use(struct model *model, const control_law *law, const struct muscle_functions *muscles);

/* Return an array of the loop or the law of a controller, by name, and its length; NULL if it does not exist. */
double *native_controller_array(struct model *model, const char *name, size_t *length);

#endif
