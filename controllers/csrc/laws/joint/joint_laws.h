/* The laws in joint space. A law is one file, <name>.c, with the function <name>_torque, and one line here:
   JOINT_LAW(name, whether it needs gravity, G, beside h).                                              */
#ifndef CARDSFLOW_JOINT_LAWS_H
#define CARDSFLOW_JOINT_LAWS_H

#include "../torque_state.h"

#define JOINT_LAWS(JOINT_LAW)      \
    JOINT_LAW(joint_space, 0)      \
    JOINT_LAW(lyapunov, 1)         \
    JOINT_LAW(force_position, 0)   \
    JOINT_LAW(torque_position, 0)

/* tau, n, from the arrays of the handle. */
#define DECLARE_JOINT_LAW(name, needs_gravity) void name##_torque(const computed_torque *s, real *tau);
JOINT_LAWS(DECLARE_JOINT_LAW)
#undef DECLARE_JOINT_LAW

#endif
