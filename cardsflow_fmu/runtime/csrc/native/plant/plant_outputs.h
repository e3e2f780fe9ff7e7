/* The outputs of a native plant. Each function returns nonzero with a message on failure. */
#ifndef NATIVE_PLANT_OUTPUTS_H
#define NATIVE_PLANT_OUTPUTS_H

#include "state.h"

/* Move the core to its q and qd. */
int native_plant_move(struct model *model);

/* Write the outputs at the state of the core. */
int native_plant_write_outputs(struct model *model);

/* Report that the command of a muscle is not finite. */
int native_plant_report_bad_command(struct model *model, size_t muscle);

#endif
