/* Task coordinates. */
#ifndef CARDSFLOW_TASKS_H
#define CARDSFLOW_TASKS_H

#include "../blob/state.h"

/* Compute task_values at the last q. */
CORE_INSIDE void tasks_move(core *c);

#endif
