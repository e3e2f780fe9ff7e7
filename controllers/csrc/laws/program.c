#include "program.h"

#include <string.h>

int solve_from(dual_newton *program, real *start)
{
    memcpy(program->start, start, program->m * sizeof(real));
    const int status = dual_newton_solve(program);
    memcpy(start, program->start, program->m * sizeof(real));
    return status;
}
