/* Model exchange for any version of FMI: states, derivatives and events. */
#ifndef INSTANCE_MODEL_EXCHANGE_H
#define INSTANCE_MODEL_EXCHANGE_H

#include "instance.h"

#include <stddef.h>

enum status continuous_set_time(struct instance *instance, double time);
enum status continuous_set_states(struct instance *instance, const double *states, size_t count);
enum status continuous_get_states(struct instance *instance, double *states, size_t count);
enum status continuous_get_derivatives(struct instance *instance, double *derivatives, size_t count);
enum status continuous_get_indicators(struct instance *instance, double *indicators, size_t count);
enum status continuous_get_nominals(struct instance *instance, double *nominals, size_t count);

/* `has_event` is set to whether event mode is required. */
enum status continuous_complete_step(struct instance *instance, int *has_event);
enum status continuous_enter_event_mode(struct instance *instance);
enum status continuous_enter_continuous_mode(struct instance *instance);
/* Compute the outputs of discrete states, which are those of the states. */
enum status continuous_evaluate(struct instance *instance);
/* Handle the events. `changed` is set to whether the states changed. */
enum status continuous_update(struct instance *instance, int *changed);

#endif
