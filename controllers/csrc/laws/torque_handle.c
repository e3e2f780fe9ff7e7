/* The handle of the laws: its memory, its arrays, and the selection of the law. */
#include "distribution.h"
#include "law_choice.h"
#include "operational_space.h"
#include "torque_state.h"

#include "../../../sim_dart/csrc/optional_parts.h"

#include <math.h>
#include <string.h>

/* Return the number of variables: the law in operational space has qdd in addition to f. */
static int variables_of(int n, int m, int k)
{
    return k ? n + m : m;
}

static int max_variables(int n, int m, int k)
{
    return k ? n + m : 2 * m;
}

size_t computed_torque_size(int coordinates, int muscles, int tasks)
{
    if (coordinates < 1 || muscles < 1 || tasks < 0 || (tasks && !USES_TASKS) || coordinates > DUAL_NEWTON_LARGEST_SIZE / 2 ||
        muscles > DUAL_NEWTON_LARGEST_SIZE / 2 || tasks > DUAL_NEWTON_LARGEST_SIZE / 2)
        return 0;
    const size_t n = (size_t)coordinates, m = (size_t)muscles, k = (size_t)tasks;
    const size_t r = k ? k : n, rows = n + k;
    const size_t program = dual_newton_size(variables_of(coordinates, muscles, tasks), coordinates + tasks);
    const size_t second = dual_newton_size(max_variables(coordinates, muscles, tasks), coordinates + tasks);
    size_t count = 0;
    TORQUE_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(computed_torque)) + padded(program) + padded(second) + count * sizeof(real);
}

computed_torque *computed_torque_open(int coordinates, int muscles, int tasks, void *memory)
{
    const size_t size = computed_torque_size(coordinates, muscles, tasks);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    computed_torque *s = memory;
    const size_t n = s->n = (size_t)coordinates, m = s->m = (size_t)muscles, k = s->k = (size_t)tasks;
    const size_t r = s->r = k ? k : n, rows = s->rows = n + k;
    const int variables = variables_of(coordinates, muscles, tasks);
    char *rest = (char *)memory + padded(sizeof *s);
    s->hard = s->built = dual_newton_open(variables, (int)rows, rest);
    rest += padded(dual_newton_size(variables, (int)rows));
    s->second = rest;
    rest += padded(dual_newton_size(max_variables(coordinates, muscles, tasks), (int)rows));
    real *at = (real *)(void *)rest;
    TORQUE_ARRAYS(NAMED_PLACE)
    return s;
}

real *computed_torque_array(computed_torque *s, const char *name, size_t *length)
{
    const size_t n = s->n, m = s->m, k = s->k, r = s->r, rows = s->rows;
    TORQUE_ARRAYS(NAMED_FIND)
    return NULL;
}

/* Return the value nearest to zero within the bounds: motors at joints may also push. */
static real nearest_to_zero(real low, real high)
{
    return low >= 0 ? low : high < 0 ? high : 0;
}

void computed_torque_reset(computed_torque *s)
{
    memset(s->memory, 0, (s->m + 2 * s->rows) * sizeof(real));
    for (size_t i = 0; i < s->m; i++) s->memory[i] = s->forces[i] = nearest_to_zero(s->f_min[i], s->f_max[i]);
}

/* Store the forces of a solution as the last ones for the next call. */
static int store_forces(computed_torque *s, int status)
{
    if (status < COMPUTED_TORQUE_FAILED) memcpy(s->memory, s->forces, s->m * sizeof(real));
    return status;
}

static int has_tasks(const computed_torque *s)
{
    return USES_TASKS && s->k;
}

int computed_torque_solve(computed_torque *s)
{
    return store_forces(s, has_tasks(s) ? operational_space_solve(s) : distribution_solve(s));
}

void computed_torque_require(computed_torque *s)
{
    joint_law_torque(s);
}

int computed_torque_build(computed_torque *s)
{
    return has_tasks(s) ? operational_space_build(s) : distribution_build(s);
}

dual_newton *computed_torque_program(computed_torque *s)
{
    return s->built;
}

int computed_torque_finish(computed_torque *s, const real *x)
{
    for (size_t i = 0; i < s->built->n; i++)
        if (!isfinite(x[i])) return COMPUTED_TORQUE_FAILED;
    return store_forces(s, has_tasks(s) ? operational_space_finish(s, x) : distribution_finish(s, x));
}
