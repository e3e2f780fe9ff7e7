/* Directional derivatives of the outputs of an instance. */
#ifndef DERIVATIVE_H
#define DERIVATIVE_H

#include "instance.h"

#include <stddef.h>
#include <stdint.h>

/* A request in value references; an array includes all of its elements. */
struct derivative_call {
    const uint32_t *unknowns;
    size_t unknown_count;
    const uint32_t *knowns;
    size_t known_count;
    const double *seeds;
    size_t seed_count;
    double *answers;
    size_t answer_count;
};

/* Compute derivatives: in initialization mode, of the outputs at the start; later, of the outputs after a
 * step of the preferred length, or, in model exchange, of outputs and state derivatives at the state. After an error the state of the instance does not change. */
enum status get_directional_derivative(struct instance *instance,
                                       const struct derivative_call *call);

#endif
