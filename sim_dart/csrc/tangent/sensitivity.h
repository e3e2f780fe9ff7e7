/* Roll-outs with their derivatives by the numbers of the robot and by the start state, for calibration. They only
   exist if derivatives are supported: see support.h. */
#ifndef CARDSFLOW_SENSITIVITY_H
#define CARDSFLOW_SENSITIVITY_H

#include "../core.h"
#include "support.h"

typedef struct core_sensitivity core_sensitivity;

/* Return the number of reals in the blob of the robot, in the order of its fields. */
CORE_API size_t core_sensitivity_numbers(const core *plain);

/* Return the size of memory in bytes for a robot. */
CORE_API size_t core_sensitivity_size(const core *plain);

/* Create a handle in `memory`, which is 8-byte aligned; see core_tangent_open. */
CORE_API core_sensitivity *core_sensitivity_open(const core *plain, void *memory);

/* Simulate from q and qd through `rows` measurements, with `steps` steps of h between measurements, constant
   commands, rows x muscles, and joint torques, rows x dofs, after each of them. Compute q and path lengths
   at each measurement, rows x (dofs + muscles), and their derivatives, rows x (dofs + muscles) x (directions
   + 2 dofs). A direction is a change of the numbers of the robot, directions x numbers, and of the commands:
   `commanded` is the index of its changes, rows x muscles each, or -1. The last 2 dofs directions are q and
   qd at the start. With NULL and no directions, only the measurements are computed. Bends of cables with
   friction start with the states of the plain handle. Return 0, or 1 + the measurement before which the
   state has diverged. */
CORE_API int core_sensitivity_roll(core_sensitivity *s, const double *q, const double *qd, int32_t rows, int32_t steps,
                                   double h, const double *commands, const double *torques, int32_t directions,
                                   const double *robot_changes, const double *command_changes,
                                   const int32_t *commanded, double *readings, double *derivatives);

#endif
