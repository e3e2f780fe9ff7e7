/* Interface between FMI and the model: a table of functions that a backend fills in. */
#ifndef MODEL_H
#define MODEL_H

#include "../platform/text.h"

#include <stddef.h>
#include <stdint.h>

struct model;

/* A request for directional derivatives: unknowns and knowns are indices into `model->values`. */
struct derivative {
    size_t unknown_count;
    const uint32_t *unknowns;
    size_t known_count;
    const uint32_t *knowns;
    const double *seeds; /* one for each known */
    double *answers;     /* one for each unknown, to be filled in */
};

/* Each returns 0, or nonzero with a message in `model->error`. */
struct model_functions {
    /* Apply the parameters, go to the start state and compute the outputs there. */
    int (*initialize)(struct model *model);
    /* Advance from clock[0] by clock[1] with constant inputs. A step whose length is impossible fails before
     * any change and sets clock[1] to 0; the next step may have another length. */
    int (*step)(struct model *model);
    /* Restore the start values; also used after a failure. */
    int (*reset)(struct model *model);
    /* Release resources outside of the process; outputs stay readable, and a reset is possible. NULL if the
     * backend has no such resources. */
    int (*terminate)(struct model *model);
    /* Return the internal state beyond `values`, as bytes on the heap that the caller frees. */
    int (*get_state)(struct model *model, void **bytes, size_t *size);
    int (*set_state)(struct model *model, const void *bytes, size_t size);
    /* Compute derivatives of the unknowns by the knowns, at the current state, which does not change. NULL
     * if the backend does not support derivatives; a model without derivatives returns a failure without
     * other effects. */
    int (*derivative)(struct model *model, const struct derivative *request);
    void (*close)(struct model *model);
};

/* Functions of a model in continuous time, for model exchange. Its states are q, qd and the states of
 * muscles. Each int function returns 0, or nonzero with a message in `model->error`. */
struct continuous_functions {
    void (*get_states)(const struct model *model, double *states);
    void (*set_states)(struct model *model, const double *states);
    /* Compute outputs, derivatives and event indicators at the states and inputs. */
    int (*evaluate)(struct model *model);
    /* Handle an event. `changed` is set to whether the states changed. */
    int (*update)(struct model *model, int *changed);
    /* Return whether an event is due after an integrator step, at the last evaluation. */
    int (*has_event)(struct model *model);
};

/* The parts of a model in continuous time. The arrays belong to the backend. */
struct continuous {
    const struct continuous_functions *functions; /* NULL for a model that computes in steps */
    size_t state_count, indicator_count;
    const double *derivatives, *indicators, *nominals;
};

/* The backend owns the memory of clock and values, so that it can share the memory with another process and
 * keep it until all users have released it. */
struct model {
    const struct model_functions *functions;
    void *backend;
    double *clock;  /* time at the beginning of the step and its length, both in s */
    const double *internal_step; /* in s; a step may be split into such steps. NULL for models without them */
    double *values; /* one for each variable of the port table */
    struct continuous continuous;
    struct text error;
};

#endif
