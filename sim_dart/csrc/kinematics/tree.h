/* Kinematics of the tree: poses of all frames. */
#ifndef CARDSFLOW_TREE_H
#define CARDSFLOW_TREE_H

#include "../blob/state.h"

CORE_INSIDE void tree_prepare(core *c);
/* Move to q. */
CORE_INSIDE void tree_move(core *c, const real *q);
/* Compute a direction of a frame in the world. */
CORE_INSIDE void tree_direction(const core *c, int32_t frame, const real local[3], real world[3]);

#endif
