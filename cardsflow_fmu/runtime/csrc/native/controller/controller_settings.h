/* The settings of a native controller. */
#ifndef NATIVE_CONTROLLER_SETTINGS_H
#define NATIVE_CONTROLLER_SETTINGS_H

#include "state.h"

/* Read the settings in the file, and the values of each group of variables. Return nonzero with a message on
   failure. */
int native_controller_settings(struct controller *c, const struct native_model *native, struct text *error);

/* Set the data of the law and the loop, after they are open. Return nonzero with a message on failure. */
int native_controller_fill(struct controller *c, const struct native_model *native, struct text *error);

#endif
