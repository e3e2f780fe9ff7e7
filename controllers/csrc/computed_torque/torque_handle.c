/* The handle of the computed-torque laws: its memory, and its arrays. */
#include "joint_space.h"
#include "operational_space.h"
#include "state.h"

#include <string.h>

/* The law in operational space has the motion equation beside the tasks, and qdd beside f. */
static int variables_of(int n, int m, int k)
{
    return k ? n + m : m;
}

static size_t padded(size_t size)
{
    return (size + 7u) & ~(size_t)7u;
}

size_t computed_torque_size(int coordinates, int muscles, int tasks)
{
    if (coordinates < 1 || muscles < 1 || tasks < 0 || coordinates > DUAL_NEWTON_LARGEST_SIZE / 2 ||
        muscles > DUAL_NEWTON_LARGEST_SIZE / 2 || tasks > DUAL_NEWTON_LARGEST_SIZE / 2)
        return 0;
    const size_t n = (size_t)coordinates, m = (size_t)muscles, k = (size_t)tasks;
    const size_t r = k ? k : n, rows = n + k;
    const size_t program = dual_newton_size(variables_of(coordinates, muscles, tasks), coordinates + tasks);
    size_t doubles = 0;
#define ADD_LENGTH(name, length) doubles += length;
    TORQUE_ARRAYS(ADD_LENGTH)
#undef ADD_LENGTH
    return padded(sizeof(computed_torque)) + 2 * padded(program) + doubles * sizeof(real);
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
    char *at = (char *)memory + padded(sizeof *s);
    s->hard = dual_newton_open(variables, (int)rows, at);
    at += padded(dual_newton_size(variables, (int)rows));
    s->soft = dual_newton_open(variables, (int)rows, at);
    at += padded(dual_newton_size(variables, (int)rows));
#define PLACE(name, length) s->name = (real *)(void *)at, at += (length) * sizeof(real);
    TORQUE_ARRAYS(PLACE)
#undef PLACE
    return s;
}

real *computed_torque_array(computed_torque *s, const char *name, size_t *length)
{
    const size_t n = s->n, m = s->m, k = s->k, r = s->r, rows = s->rows;
#define FIND(name_, length_) \
    if (!strcmp(name, #name_)) return *length = length_, s->name_;
    TORQUE_ARRAYS(FIND)
#undef FIND
    return NULL;
}

/* Nothing, where the bounds allow it: motors of joints may push as well. */
static real smallest(real low, real high)
{
    return low >= 0 ? low : high < 0 ? high : 0;
}

void computed_torque_reset(computed_torque *s)
{
    memset(s->memory, 0, (s->m + 2 * s->rows) * sizeof(real));
    for (size_t i = 0; i < s->m; i++) s->memory[i] = s->forces[i] = smallest(s->f_min[i], s->f_max[i]);
}

int computed_torque_solve(computed_torque *s)
{
    const int status = s->k ? operational_space_solve(s) : joint_space_solve(s);
    if (status < COMPUTED_TORQUE_FAILED) memcpy(s->memory, s->forces, s->m * sizeof(real));
    return status;
}
