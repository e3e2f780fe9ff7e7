/* The state functions of FMI 2 and FMI 3, which differ only in their names. */
#ifndef STATE_CALLS_H
#define STATE_CALLS_H

#include "instance.h"

#include <stddef.h>

/* States are saved_states behind void pointers. A null pointer is rejected without changing the state of the
 * instance; the instance may also be NULL. If *state is a state, it is replaced. */
enum status state_get(struct instance *instance, void **state);
enum status state_set(struct instance *instance, const void *state);
enum status state_free(void **state);
enum status state_size(struct instance *instance, const void *state, size_t *size);
enum status state_serialize(struct instance *instance, const void *state, void *bytes, size_t size);
enum status state_deserialize(struct instance *instance, const void *bytes, size_t size,
                              void **state);

#endif
