/* The reference as a native model; it has no robot. */
#ifndef NATIVE_REFERENCE_H
#define NATIVE_REFERENCE_H

#include "model.h"

/* Fill in the functions. Return 0, or nonzero with a message. */
int native_reference_open(struct model *model, struct native_model *native, struct text *error);

#endif
