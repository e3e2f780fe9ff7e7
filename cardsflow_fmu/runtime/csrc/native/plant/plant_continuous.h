/* A native plant in continuous time, for model exchange. */
#ifndef NATIVE_PLANT_CONTINUOUS_H
#define NATIVE_PLANT_CONTINUOUS_H

#include "state.h"

/* Set the continuous functions of the model. */
void native_plant_continuous_open(struct model *model);

/* Common parts of both kinds of plants, in plant.c. Each function returns nonzero with a message on failure. */

/* Move the core to its q and qd. */
int native_plant_move(struct model *model);
/* Write the outputs at the state of the core. */
int native_plant_write_outputs(struct model *model);
int native_plant_report_bad_command(struct model *model, size_t muscle);

#endif
