/* An instance of an FMU: its life cycle, its time and its model, whatever the version of FMI. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "../model/model.h"
#include "../model/port_table.h"
#include "../platform/text.h"
#include "log.h"

/* Flags, so that a set of them can be named. */
enum life_cycle {
    INSTANTIATED = 1,
    INITIALIZATION_MODE = 2,
    STEP_MODE = 4,
    TERMINATED = 8,
    FAILED = 16
};

struct instance {
    struct log log;
    struct port_table ports;
    struct model model;
    enum life_cycle life_cycle;
    int has_time_variable;     /* whether the value reference behind the last one means the time */
    int is_set_up;             /* whether the start time is known */
    int initialization_is_due; /* whether something was set since the model's last initialize */
    double start_time, stop_time, time;
};

/* Opens the FMU whose resources are in `folder`; NULL after a message in the log. */
struct instance *instance_open(const struct log *log, const char *guid, const char *folder);
void instance_close(struct instance *instance);

/* The times of the experiment; `call` is what FMI calls the function that sets them. */
enum status instance_set_up(struct instance *instance, const char *call, double start_time,
                            double stop_time);
enum status instance_enter_initialization_mode(struct instance *instance);
enum status instance_exit_initialization_mode(struct instance *instance);
enum status instance_step(struct instance *instance, double time, double step);
enum status instance_terminate(struct instance *instance);
enum status instance_reset(struct instance *instance);

/* Whether the call may be made now; else the instance fails. */
int instance_allows(struct instance *instance, const char *call, unsigned life_cycles);

/* Makes the outputs agree with what was set. */
enum status instance_update(struct instance *instance);

/* Reports an error after which only a reset or an earlier state helps. */
enum status instance_fail(struct instance *instance, const char *format, ...) TEXT_FORMAT(2, 3);

#endif
