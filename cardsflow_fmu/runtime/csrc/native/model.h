/* What the models of native FMUs share: the memory of their variables, and bytes of states. */
#ifndef NATIVE_MODEL_H
#define NATIVE_MODEL_H

#include "../model/model.h"
#include "../model/port_table.h"
#include "file.h"
#include "robot.h"

struct native_model {
    struct native_file file;
    struct native_robot robot;
    const struct port_table *ports;
    double clock[2];
    double *values;     /* in the order of the ports */
    double *own_values; /* where they are, or NULL if they are in the caller's memory */
    void *own;      /* the model's own memory */
};

/* Frees what native_open made; `own` has been freed. */
void native_close(struct native_model *native);

/* The values of a group of variables; NULL, with a message, if there are not so many of them, or where the
 * FMU has not so many variables. */
#define ANY ((size_t)-1)
double *native_values(const struct native_model *native, struct native_group group, const char *name,
                      size_t count, struct text *error);

/* The start values of the ports. */
int native_reset(struct model *model);

/* How many periods a time is; 0 with a message in `error` if it is not a whole number of them, or too many. */
size_t native_whole_steps(double time, double step, const char *what, struct text *error);

/* A copy on the heap of numbers that a model remembers. 0, or nonzero with a message. */
int native_save(const double *const *parts, const size_t *sizes, size_t count, void **bytes, size_t *size,
                struct text *error);
/* The other way round; nonzero with a message where the size does not fit or a number is not finite. */
int native_restore(double *const *parts, const size_t *sizes, size_t count, const void *bytes, size_t size,
                   struct text *error);

#endif
