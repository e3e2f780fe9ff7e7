/* What both laws share: the acceleration that they ask for, and their programs. */
#ifndef CARDSFLOW_PROGRAM_H
#define CARDSFLOW_PROGRAM_H

#include "torque_state.h"

/* acceleration + correction + Kd rate_error + Kp error */
void desired_acceleration(const computed_torque *s, real *desired);
/* Solve a program from where the last of its kind ended, kept in `start`. */
int solve_from(dual_newton *program, real *start);

#endif
