/* Common parts of the laws: the desired acceleration, and the quadratic programs. */
#ifndef CARDSFLOW_PROGRAM_H
#define CARDSFLOW_PROGRAM_H

#include "torque_state.h"

#include <string.h>

/* Compute acceleration + correction + Kd rate_error + Kp error. */
static inline void desired_acceleration(const computed_torque *s, real *desired)
{
    for (size_t i = 0; i < s->r; i++)
        desired[i] = s->acceleration[i] + s->correction[i] + s->kd[i] * s->rate_error[i] + s->kp[i] * s->error[i];
}

/* Solve a program from the result of the last program of this kind, which is stored in `start`. */
static inline int solve_from(dual_newton *program, real *start)
{
    memcpy(program->start, start, program->m * sizeof(real));
    const int status = dual_newton_solve(program);
    memcpy(start, program->start, program->m * sizeof(real));
    return status;
}

/* Return the program in the second memory: the one with soft rows; or, in joint space, the one of twice the
   variables, for forces in two parts with the norm 1. */
static inline dual_newton *second_program(computed_torque *s, size_t variables)
{
    if (s->second_variables != variables) dual_newton_open((int)variables, (int)s->rows, s->second);
    s->second_variables = variables;
    return s->second;
}

#endif
