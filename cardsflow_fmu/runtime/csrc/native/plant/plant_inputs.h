/* The inputs of a native plant, and the names of its variables. */
#ifndef NATIVE_PLANT_INPUTS_H
#define NATIVE_PLANT_INPUTS_H

#include "state.h"

/* Compute and return `muscle_commands`: the command of every muscle, in the order of the robot. */
const double *native_plant_commands(const struct plant *plant);

/* Return the motor torques on all coordinates, for the step of the core; NULL without motors. */
const double *native_plant_torques(const struct plant *plant);

/* Copy commands, torques, loads and wrenches to the arrays for the step of the core. Return nonzero with a
 * message if a torque, load or wrench is not finite. */
int native_plant_apply_inputs(struct model *model);

#endif
