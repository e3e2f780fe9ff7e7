/* The plant as a native model. */
#ifndef NATIVE_PLANT_H
#define NATIVE_PLANT_H

#include "../model.h"

/* Fill in the functions, and the data of the model beyond the robot. Return 0, or nonzero with a message. */
int native_plant_open(struct model *model, struct native_model *native, struct text *error);

#endif
