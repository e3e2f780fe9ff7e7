/* Common parts of native models: the memory of their variables, and bytes of states. */
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
    double *own_values; /* the same values, or NULL if the caller owns them */
    void *data;     /* data of the model */
    const struct native_functions *functions;
};

enum { NATIVE_STATE_PARTS = 8 };
/* Functions of a kind of native models. */
struct native_functions {
    struct model_functions model;
    size_t size; /* of the data, which are 0 before `open` */
    /* Fill in the data of the model beyond the robot. Return 0, or nonzero with a message. */
    int (*open)(struct model *model, struct native_model *native, struct text *error);
    /* List the arrays of the internal state with their lengths; return their number. */
    size_t (*list_state)(struct native_model *native, double **parts, size_t *sizes);
    int (*after_restore)(struct model *model); /* or NULL */
    void (*release)(void *data);
};
extern const struct native_functions native_plant, native_controller, native_reference, native_sensors,
    native_estimator;

/* Functions that all native models share. */
#define NATIVE_FUNCTIONS                                                                                      \
    .reset = native_reset, .get_state = native_get_state, .set_state = native_set_state, .close = native_close_model

/* Set the pointers of `data` to the values of a group, in a function that returns nonzero on failure. */
#define NATIVE_PLACE(name, length)                                                                            \
    if (!(data->name = native_values(native, data->settings.of.name, #name, length, error)))                  \
        return 1;

/* Free the model and its own data. NULL is allowed. */
void native_close(struct native_model *native);
void native_close_model(struct model *model);

/* Return the values of a group of variables; NULL, with a message, if the size of the group differs or
 * exceeds the variables of the FMU. */
#define ANY ((size_t)-1)
double *native_values(const struct native_model *native, struct native_group group, const char *name,
                      size_t count, struct text *error);

/* Restore the start values of the ports. */
int native_reset(struct model *model);

/* Return the name of the variable of a value. */
const char *native_port_name(const struct native_model *native, const double *value);

/* Return the number of periods in a time; 0 with a message in `model->error` if it is not a whole number, or
 * too large. The period is a parameter. The host may then try a step of another length. */
size_t native_whole_steps(double time, const double *parameter, const char *label, struct model *model);

/* Copy the internal state of a model to the heap. Return 0, or nonzero with a message. */
int native_get_state(struct model *model, void **bytes, size_t *size);
/* Restore the internal state. Return nonzero with a message if the size differs or a number is not finite. */
int native_set_state(struct model *model, const void *bytes, size_t size);

#endif
