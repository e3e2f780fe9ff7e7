/* Roll-outs with their derivatives by the robot's numbers and by where they begin, for calibration. */
#ifndef CARDSFLOW_SENSITIVITY_H
#define CARDSFLOW_SENSITIVITY_H

#include "../core.h"
#include "support.h"

typedef struct core_sensitivity core_sensitivity;

/* Real numbers of the robot's blob, in the order of its fields. */
CORE_API size_t core_sensitivity_numbers(const core *plain);

/* Bytes of memory for a robot; 0 if there are no derivatives: see support.h. */
CORE_API size_t core_sensitivity_size(const core *plain);

/* A handle in `memory`, 8-byte aligned; see core_tangent_open. NULL if there are no derivatives. */
CORE_API core_sensitivity *core_sensitivity_open(const core *plain, void *memory);

/* From q and qd through `rows` readings, with `steps` steps of h between one reading and the next, constant
   commands, rows x muscles, and torques at joints, rows x dofs, from each on: q and path lengths at each reading,
   rows x (dofs + muscles), and their derivatives, rows x (dofs + muscles) x (directions + 2 dofs). A direction is a
   change of the robot's numbers, directions x numbers, and of the commands: `commanded` is the index of its
   changes, rows x muscles each, or -1; behind them are q and qd at the start. NULL and no directions for the
   readings alone. Bends of cables with friction begin with the states that the plain handle has. 0, or 1 + the
   reading that the state has diverged before.                                                                   */
CORE_API int core_sensitivity_roll(core_sensitivity *s, const double *q, const double *qd, int32_t rows, int32_t steps,
                                   double h, const double *commands, const double *torques, int32_t directions,
                                   const double *robot_changes, const double *command_changes,
                                   const int32_t *commanded, double *readings, double *derivatives);

#endif
