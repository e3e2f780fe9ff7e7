/* What both models of native FMUs share: the memory of their variables, and how they are opened. */
#ifndef NATIVE_MODEL_H
#define NATIVE_MODEL_H

#include "model.h"
#include "native_file.h"
#include "native_robot.h"
#include "port_table.h"

struct native_model {
    struct native_file file;
    struct native_robot robot;
    const struct port_table *ports;
    double clock[2];
    double *values; /* in the order of the ports */
    void *own;      /* the model's own memory */
};

/* Opens the model whose files are in the folder `resources`, in this process and without any Python. 0, or
 * nonzero with a message; the model needs no close then. */
int native_open(struct model *model, const struct port_table *ports, const char *resources,
                struct text *error);

/* Fill in the functions, and what the model needs beyond the robot, which a reference has not. 0, or nonzero with a message. */
int native_plant_open(struct model *model, struct native_model *native, struct text *error);
int native_controller_open(struct model *model, struct native_model *native, struct text *error);
int native_reference_open(struct model *model, struct native_model *native, struct text *error);

/* Frees what native_open made; `own` has been freed. */
void native_close(struct native_model *native);

/* Whether the table has that many values; else a message. */
int native_has_values(const struct native_model *native, size_t count, struct text *error);

/* The start values of the ports. */
int native_reset(struct model *model);

/* How many periods a time is; 0 with a message in `error` where it is no whole number of them. */
size_t native_whole_steps(double time, double step, const char *what, struct text *error);

/* A copy on the heap of numbers that a model remembers. 0, or nonzero with a message. */
int native_save(const double *const *parts, const size_t *sizes, size_t count, void **bytes, size_t *size,
                struct text *error);
/* The other way round; nonzero with a message where the size does not fit or a number is not finite. */
int native_restore(double *const *parts, const size_t *sizes, size_t count, const void *bytes, size_t size,
                   struct text *error);

#endif
