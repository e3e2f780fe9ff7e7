/* An instance of an FMU for any version of FMI: its life cycle, its time and its model. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "../model/model.h"
#include "../model/port_table.h"
#include "../platform/text.h"
#include "log.h"

/* Bit flags, so that functions can accept a set of them. */
enum life_cycle {
    INSTANTIATED = 1,
    INITIALIZATION_MODE = 2,
    STEP_MODE = 4,
    TERMINATED = 8,
    FAILED = 16,
    EVENT_MODE = 32, /* of model exchange, as is the next one */
    CONTINUOUS_MODE = 64
};

enum { RUNNING = STEP_MODE | EVENT_MODE | CONTINUOUS_MODE };

/* How the host uses the FMU. */
enum interface { CO_SIMULATION, MODEL_EXCHANGE };

struct instance {
    struct log log;
    struct port_table ports;
    struct model model;
    enum life_cycle life_cycle;
    int has_time_variable;     /* whether the value reference after the last one is the time */
    int is_set_up;             /* whether the start time is known */
    int initialization_is_due; /* whether a variable was set since the last initialization of the model */
    int evaluation_is_due;     /* whether states or inputs were set since the last evaluation; see model_exchange.h */
    double start_time, stop_time, time;
};

/* Open the FMU with its resources in `folder`. Return NULL after a message in the log. */
struct instance *instance_open(const struct log *log, const char *guid, const char *folder,
                               enum interface interface);
void instance_close(struct instance *instance);

/* Set the times of the experiment; `call` is the name of the FMI function. */
enum status instance_set_up(struct instance *instance, const char *call, double start_time,
                            double stop_time);
enum status instance_enter_initialization_mode(struct instance *instance);
enum status instance_exit_initialization_mode(struct instance *instance);

/* Function that is called when a step or an internal step is completed, with the end of the next internal
 * step, or the same time after the last one. It returns whether the communication step ends here. */
struct step_observer {
    int (*completed)(void *context, double time, double next);
    void *context;
};

/* Advance by a communication step. With an observer, compute the internal steps one by one. */
enum status instance_step(struct instance *instance, double time, double step, const struct step_observer *observer);
enum status instance_terminate(struct instance *instance);
enum status instance_reset(struct instance *instance);

/* Return whether the call is allowed now; otherwise the instance fails. */
int instance_allows(struct instance *instance, const char *call, unsigned life_cycles);

/* Initialize or evaluate the model again if variables were set. */
enum status instance_update(struct instance *instance);

/* Report an error that only a reset or an earlier state resolves. */
enum status instance_fail(struct instance *instance, const char *format, ...) TEXT_FORMAT(2, 3);

#endif
