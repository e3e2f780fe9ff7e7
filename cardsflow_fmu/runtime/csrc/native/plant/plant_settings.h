/* The settings of a native plant. */
#ifndef NATIVE_PLANT_SETTINGS_H
#define NATIVE_PLANT_SETTINGS_H

#include "state.h"

/* Takes over the settings in the file, finds room for what they ask for, and the values of each group of
 * variables; nonzero with a message. */
int native_plant_settings(struct plant *plant, struct native_model *native, struct text *error);

/* Frees it. */
void native_plant_free(struct plant *plant);

#endif
