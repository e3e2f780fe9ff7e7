/* The inputs of a native plant, and the names of its variables. */
#ifndef NATIVE_PLANT_INPUTS_H
#define NATIVE_PLANT_INPUTS_H

#include "state.h"

/* The command of every muscle, in the order of the robot, into `muscle_commands`, which it returns. */
const double *native_plant_commands(const struct plant *plant);

/* Torques of motors on all coordinates, for the core's step; NULL without motors. */
const double *native_plant_torques(const struct plant *plant);

/* Commands, torques, loads and wrenches to where the core's step looks for them. Nonzero with a message where a
 * torque, load or wrench is not finite. */
int native_plant_apply_inputs(struct model *model);

/* The name of the variable that a value is of. */
const char *native_port_name(const struct native_model *native, const double *value);

#endif
