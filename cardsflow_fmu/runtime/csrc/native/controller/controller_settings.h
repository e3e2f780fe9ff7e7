/* The settings of a native controller. */
#ifndef NATIVE_CONTROLLER_SETTINGS_H
#define NATIVE_CONTROLLER_SETTINGS_H

#include "state.h"

/* Takes over the settings in the file, and the values of each group of variables; nonzero with a message. */
int native_controller_settings(struct controller *c, const struct native_model *native, struct text *error);

/* Fills in what the law and the loop hold, once they are open; nonzero with a message. */
int native_controller_fill(struct controller *c, const struct native_model *native, struct text *error);

#endif
