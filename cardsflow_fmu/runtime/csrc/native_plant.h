/* The inside of a native plant. */
#ifndef NATIVE_PLANT_H
#define NATIVE_PLANT_H

#include "native_model.h"

#include <stddef.h>

struct plant {
    double ticks, substeps;
    size_t c, t, s;
    const double *commanded, *modelled, *order;
    double *told; /* m: the command of every muscle; of passive ones 0 */
    double *commands, *loads, *q, *qd, *lengths, *tasks, *tensions, *states, *q_start, *qd_start, *step;
    struct core_along *along; /* from the first question for a derivative on */
};

/* See model_functions.derivative. */
int native_plant_derivative(struct model *model, const struct derivative *request);

#endif
