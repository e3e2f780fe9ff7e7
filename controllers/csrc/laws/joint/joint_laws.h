/* The laws in joint space. A law consists of one file in this folder, <name>.c, with the function
   <name>_torque, and an entry in the table controllers/laws/joint_laws.py. */
#ifndef CARDSFLOW_JOINT_LAWS_H
#define CARDSFLOW_JOINT_LAWS_H

#include "../../../generated/joint_law_list.h" /* JOINT_LAW(name, whether it needs G in addition to h) */
#include "../torque_state.h"

/* Compute tau, n, from the arrays of the handle. */
#define DECLARE_JOINT_LAW(name, needs_gravity) void name##_torque(const computed_torque *s, real *tau);
JOINT_LAWS(DECLARE_JOINT_LAW)
#undef DECLARE_JOINT_LAW

#endif
