/* The settings of a native plant. */
#ifndef NATIVE_PLANT_SETTINGS_H
#define NATIVE_PLANT_SETTINGS_H

#include "state.h"

/* Read the settings in the file, allocate memory, and find the values of each group of variables. Return
 * nonzero with a message on failure. */
int native_plant_settings(struct plant *plant, struct native_model *native, struct text *error);

/* Free this memory. */
void native_plant_free(void *data);

#endif
