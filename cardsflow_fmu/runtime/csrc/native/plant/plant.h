/* The plant as a native model. */
#ifndef NATIVE_PLANT_H
#define NATIVE_PLANT_H

#include "../model.h"

/* Fills in the functions, and what the model needs beyond the robot. 0, or nonzero with a message. */
int native_plant_open(struct model *model, struct native_model *native, struct text *error);

#endif
