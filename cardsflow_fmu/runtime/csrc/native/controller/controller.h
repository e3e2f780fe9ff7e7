/* The controller as a native model. */
#ifndef NATIVE_CONTROLLER_H
#define NATIVE_CONTROLLER_H

#include "../model.h"

/* Fills in the functions, and what the model needs beyond the robot. 0, or nonzero with a message. */
int native_controller_open(struct model *model, struct native_model *native, struct text *error);

#endif
