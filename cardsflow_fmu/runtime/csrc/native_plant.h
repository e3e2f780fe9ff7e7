/* The inside of a native plant.
 *
 * Values: commands (c), loads (3 p), wrenches (6 k); q (n), qd (n), l (m), y, tensions (t), states (s), books
 * of energy (11 or none); start q (n), start qd (n), step, worker_timeout. */
#ifndef NATIVE_PLANT_H
#define NATIVE_PLANT_H

#include "native_model.h"

#include <stddef.h>
#include <stdint.h>

enum { BOOKS = 11 }; /* energies 2, work 3, momentum 3, angular momentum 3 */

/* A rule of the core: core_step or core_runge_kutta. */
typedef int plant_rule(core *c, const double *u, const double *extra, double h, int32_t steps);

struct plant {
    double ticks, substeps;
    plant_rule *rule;
    size_t c, t, s, k;
    const double *commanded, *modelled, *order;
    size_t books;    /* 0 where it keeps none */
    double standing; /* potential energy of what does not move */
    double work[3];  /* since the start; see core.h */
    double *told;    /* m: the command of every muscle; of passive ones 0 */
    int32_t *frames; /* p + k: of what is pushed */
    double *pushes;  /* 6 a point: see core_push */
    double *commands, *loads, *wrenches, *q, *qd, *lengths, *tasks, *tensions, *states, *energies;
    double *q_start, *qd_start, *step;
    struct core_along *along; /* from the first question for a derivative on */
};

/* Takes the settings off the file's and finds room for what they ask for; nonzero with a message. */
int native_plant_settings(struct plant *plant, struct native_model *native, struct text *error);

/* Finds where the values stand; nonzero with a message where they are not as many. */
int native_plant_place(struct plant *plant, const struct native_model *native, struct text *error);

/* Frees it. */
void native_plant_free(struct plant *plant);

/* Commands, loads and wrenches to where the core's step looks for them: `told` and `pushes`. Nonzero with a
 * message where a load or wrench is not finite. */
int native_plant_tell(struct model *model);

/* See model_functions.derivative. */
int native_plant_derivative(struct model *model, const struct derivative *request);

#endif
