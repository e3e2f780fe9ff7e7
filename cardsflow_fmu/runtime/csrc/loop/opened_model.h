/* A native model in a host program that provides its memory; Python uses it with ctypes.
 *
 * Every model must be called from one thread at a time. */
#ifndef OPENED_MODEL_H
#define OPENED_MODEL_H

#include "../model/model.h"
#include "../model/port_table.h"
#include "../native/controller/controller.h"

#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define NATIVE_API __declspec(dllexport)
#else
#define NATIVE_API __attribute__((visibility("default")))
#endif

struct opened_model {
    struct model model;
    struct port_table ports;
    void *state; /* the bytes of native_model_get_state */
};

/* Return the layout of a kind of model, 0 plant, 1 controller, 2 reference, 3 sensors, 4 estimator: see
 * native/layout.h. Return NULL for other kinds. */
NATIVE_API const char *native_model_layout(int32_t kind);
NATIVE_API uint32_t native_model_layout_hash(int32_t kind);

/* Open a model from the contents of its native.bin and its ports.bin, which are copied. The variables are in
 * `values`, which must contain the start values and outlive the model. Return NULL with a message on
 * failure. */
NATIVE_API struct opened_model *native_model_open(const void *file, size_t size, const void *ports,
                                                  size_t ports_size, double *values, char *message,
                                                  size_t capacity);
NATIVE_API void native_model_close(struct opened_model *opened);

/* Each function returns 0, or nonzero with a message: see model_functions. Times are in s. */
NATIVE_API int native_model_initialize(struct opened_model *opened, double t);
/* A step of an impossible length fails with NATIVE_MODEL_DISCARDED; the model has not changed. */
enum { NATIVE_MODEL_DISCARDED = 2 };
NATIVE_API int native_model_step(struct opened_model *opened, double t, double h);
/* The bytes belong to the model and are valid until the next call. */
NATIVE_API int native_model_get_state(struct opened_model *opened, void **bytes, size_t *size);
NATIVE_API int native_model_set_state(struct opened_model *opened, const void *bytes, size_t size);

/* Set Python functions of a controller: see native/controller/controller.h. */
NATIVE_API int native_model_use(struct opened_model *opened, const control_law *law,
                                const struct muscle_functions *muscles);
/* Return an array of the loop or the law of a controller, or of the robot of any model but a reference, by name,
 * and its length: see control_loop.h and core.h. Return NULL if it does not exist. */
NATIVE_API double *native_model_array(struct opened_model *opened, const char *name, size_t *length);

/* Write a polyline along each muscle of the robot, for drawing, and return the number of points: see core_lines. */
NATIVE_API int32_t native_model_lines(struct opened_model *opened, int32_t *sizes, double *points, int32_t capacity);

/* Return the last error message. */
NATIVE_API const char *native_model_message(const struct opened_model *opened);

#endif
