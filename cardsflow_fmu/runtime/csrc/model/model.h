/* The seam between FMI and whatever computes: a table of functions that a backend fills in. */
#ifndef MODEL_H
#define MODEL_H

#include "../platform/text.h"

#include <stddef.h>
#include <stdint.h>

struct model;

/* A question for a directional derivative: unknowns and knowns are indices into `model->values`. */
struct derivative {
    size_t unknown_count;
    const uint32_t *unknowns;
    size_t known_count;
    const uint32_t *knowns;
    const double *seeds; /* one for each known */
    double *answers;     /* one for each unknown, to be filled in */
};

/* Each returns 0, or nonzero with the reason in `model->error`. */
struct model_functions {
    /* Takes over the parameters, goes to the start state and computes the outputs there. */
    int (*initialize)(struct model *model);
    /* Advances from clock[0] by clock[1] with the inputs unchanged. */
    int (*step)(struct model *model);
    /* Back to the start values; also the way out after a failure. */
    int (*reset)(struct model *model);
    /* Lets go of what is held beyond the process; outputs stay readable, and a reset leads back. NULL
     * when the backend holds nothing. */
    int (*terminate)(struct model *model);
    /* What the model remembers beyond `values`, as bytes on the heap that the caller frees. */
    int (*get_state)(struct model *model, void **bytes, size_t *size);
    int (*set_state)(struct model *model, const void *bytes, size_t size);
    /* How the unknowns change with the knowns, at the present state, which stays as it is. NULL when
     * the backend offers none; a model that offers none answers with a failure that does no harm. */
    int (*derivative)(struct model *model, const struct derivative *request);
    void (*close)(struct model *model);
};

/* The memory of clock and values is the backend's, so that it can be shared with where the model
 * runs and last as long as anything there looks at it. */
struct model {
    const struct model_functions *functions;
    void *backend;
    double *clock;  /* time at the beginning of the step and its length, both in s */
    double *values; /* one for each variable of the port table */
    struct text error;
};

#endif
