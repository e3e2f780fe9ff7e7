/* A step of the plant, and how its end changes with its beginning: exact, by differentiating every
   formula of a step along one direction.

   Of robots without Coulomb friction whose muscles are ideal cables along straight segments. At a kink, a force of zero or a joint
   that just meets its limit, the derivative is that of the side on which the step lies.                  */
#ifndef CARDSFLOW_TANGENT_H
#define CARDSFLOW_TANGENT_H

#include "core.h"

/* What a step depends on, and the direction in which that changes. */
typedef struct {
    const real *forces, *forces_change; /* muscles */
    int32_t loads;                        /* forces from outside on task points */
    const real *load_tasks;             /* the index of each one's task */
    const real *load, *load_change;     /* 3 each, world axes */
    real *q_change, *qd_change;         /* dofs: at the beginning of a step; behind it at its end */
    real *memory;                       /* core_tangent_size of them */
} core_tangent;

/* Doubles of work memory; 0 for a robot that has no such derivatives. */
CORE_API size_t core_tangent_size(const core *c);

/* As core_step with these forces and loads, one step; q_change and qd_change go along. */
CORE_API int core_step_along(core *c, const core_tangent *direction, real h);

#endif
