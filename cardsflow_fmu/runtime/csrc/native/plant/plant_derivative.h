/* Directional derivatives of a native plant. */
#ifndef NATIVE_PLANT_DERIVATIVE_H
#define NATIVE_PLANT_DERIVATIVE_H

#include "../../model/model.h"

/* See model_functions.derivative. */
int native_plant_derivative(struct model *model, const struct derivative *request);

#endif
