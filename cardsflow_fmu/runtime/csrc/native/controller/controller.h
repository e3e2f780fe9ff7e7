/* The controller as a native model. */
#ifndef NATIVE_CONTROLLER_H
#define NATIVE_CONTROLLER_H

#include "../../../../../controllers/csrc/loop/control_loop.h"
#include "../model.h"
#include "muscles.h"

/* Fills in the functions, and what the model needs beyond the robot. 0, or nonzero with a message. */
int native_controller_open(struct model *model, struct native_model *native, struct text *error);

/* Puts a custom law, and muscle laws outside of C, into a controller; nonzero where the model is none. */
int native_controller_use(struct model *model, const control_law *law, const struct muscle_functions *muscles);

/* An array of a controller's loop, of its law, or of its core, by name, and its length; NULL if it does not exist. */
double *native_controller_array(struct model *model, const char *name, size_t *length);

#endif
