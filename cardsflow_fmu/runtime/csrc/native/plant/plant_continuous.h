/* A native plant in continuous time, for model exchange. */
#ifndef NATIVE_PLANT_CONTINUOUS_H
#define NATIVE_PLANT_CONTINUOUS_H

#include "state.h"

/* Set the continuous functions of the model. */
void native_plant_continuous_open(struct model *model);

#endif
