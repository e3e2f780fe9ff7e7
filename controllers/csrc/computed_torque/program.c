#include "program.h"

#include <string.h>

void desired_acceleration(const computed_torque *s, real *desired)
{
    for (size_t i = 0; i < s->r; i++)
        desired[i] = s->acceleration[i] + s->kd[i] * s->rate_error[i] + s->kp[i] * s->error[i];
}

int solve_from(dual_newton *program, real *start)
{
    memcpy(program->start, start, program->m * sizeof(real));
    const int status = dual_newton_solve(program);
    memcpy(start, program->start, program->m * sizeof(real));
    return status;
}
