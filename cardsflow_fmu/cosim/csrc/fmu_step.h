/* Steps of FMI 2.0 and FMI 3.0 instances: set the inputs, do a step, get the outputs.
 *
 * Another program loads the library of the FMU and instantiates it; fmi_calls.py does. A row is a list of
 * banks: variables of one type, which one call gets or sets. The values of all types are doubles outside of
 * this file; integers are rounded. */
#ifndef FMU_STEP_H
#define FMU_STEP_H

#include "export.h"

#include <stddef.h>
#include <stdint.h>

enum fmu_type { /* in the order of fmu_variables.py */
    FMU_DOUBLE,
    FMU_FLOAT,
    FMU_INT8,
    FMU_UINT8,
    FMU_INT16,
    FMU_UINT16,
    FMU_INT32,
    FMU_UINT32,
    FMU_INT64,
    FMU_UINT64,
    FMU_BOOL,
    FMU_BOOL2 /* of FMI 2.0: an int, 0 or 1 */
};

enum { FMU_DISCARD = 2 }; /* lowest status that means failure */

enum fmu_end { FMU_DONE, FMU_STEP_FAILED, FMU_TERMINATED, FMU_GET_FAILED };

struct fmu_row;
struct fmu;

/* Create a row without variables, of an instance of FMI 2 or 3. Return NULL if memory is insufficient. */
RUN_API struct fmu_row *fmu_row_open(int32_t version, void *instance);
RUN_API void fmu_row_close(struct fmu_row *row);
/* Add variables: the getter and setter of their type, their `count` references, which are copied, and their
 * `size` values, which must outlive the row. Return nonzero if memory is insufficient. */
RUN_API int fmu_row_add(struct fmu_row *row, int32_t type, void *get, void *set, const uint32_t *references,
                        size_t count, double *values, size_t size);
/* Get or set all variables. Return the highest status. */
RUN_API int fmu_row_get(struct fmu_row *row);
RUN_API int fmu_row_set(struct fmu_row *row);

/* Create a participant from the function fmi2DoStep or fmi3DoStep and its rows, which must outlive it. */
RUN_API struct fmu *fmu_open(int32_t version, void *instance, void *do_step, struct fmu_row *inputs,
                             struct fmu_row *outputs);
RUN_API void fmu_close(struct fmu *fmu);
/* Step from t to t + h, in s. Return a number of fmu_end. */
RUN_API int fmu_step(void *fmu, double t, double h);

#endif
