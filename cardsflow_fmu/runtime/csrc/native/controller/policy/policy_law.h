/* Policy of a controller, instead of a control law. */
#ifndef NATIVE_POLICY_LAW_H
#define NATIVE_POLICY_LAW_H

#include "../state.h"

/* Read the policy in the settings, if there is one. Return nonzero if it does not fit the robot or memory is
   insufficient; must be closed in either case. */
int native_policy_open(struct controller *c);
void native_policy_close(struct controller *c);

/* Compute forces and commands of a tick. Inputs that are not finite lead to the fallback, which the report
   states as infeasible. */
void native_policy_tick(struct controller *c, const struct native_robot *robot, double period);

#endif
