/* Sensors and estimator as native models. */
#ifndef NATIVE_ESTIMATION_MODELS_H
#define NATIVE_ESTIMATION_MODELS_H

#include "../model.h"

/* Each opens its model for an open robot. Return 0, or nonzero with a message. */
int native_sensors_open(struct model *model, struct native_model *native, struct text *error);
int native_estimator_open(struct model *model, struct native_model *native, struct text *error);

#endif
