/* The settings of a native controller. */
#ifndef NATIVE_CONTROLLER_SETTINGS_H
#define NATIVE_CONTROLLER_SETTINGS_H

#include "state.h"

/* Fills in what the law and the loop hold, from the settings that are left. 0, or nonzero where they do not
 * fit. */
int native_controller_settings(struct controller *c, struct native_model *native);

#endif
