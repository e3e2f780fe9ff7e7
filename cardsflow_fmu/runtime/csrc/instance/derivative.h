/* Directional derivatives of an instance's outputs. */
#ifndef DERIVATIVE_H
#define DERIVATIVE_H

#include "instance.h"

#include <stddef.h>
#include <stdint.h>

/* A question in value references; an array counts with all of its elements. */
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

/* In initialization mode, of the outputs at the start; later, of the outputs behind a step of the
 * preferred length. A refusal leaves the instance as it is. */
enum status get_directional_derivative(struct instance *instance,
                                       const struct derivative_call *call);

#endif
