/* The settings of a native plant. */
#ifndef NATIVE_PLANT_SETTINGS_H
#define NATIVE_PLANT_SETTINGS_H

#include "state.h"

/* Takes the settings off the file's and finds room for what they ask for; nonzero with a message. */
int native_plant_settings(struct plant *plant, struct native_model *native, struct text *error);

/* Finds where the values stand; nonzero with a message where they are not as many. */
int native_plant_place(struct plant *plant, const struct native_model *native, struct text *error);

/* Frees it. */
void native_plant_free(struct plant *plant);

#endif
