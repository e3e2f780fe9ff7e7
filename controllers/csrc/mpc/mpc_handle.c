/* The handle of model predictive control: its memory and its arrays. */
#include "mpc_state.h"

#include <string.h>

enum { MAX_TASKS = 512 };

size_t mpc_size(int coordinates, int actuators, int tasks, int nodes)
{
    const size_t program = stage_qp_size(nodes, 2 * coordinates, actuators);
    if (!program || tasks < 0 || tasks > MAX_TASKS) return 0;
    const size_t n = (size_t)coordinates, a = (size_t)actuators, r = tasks ? (size_t)tasks : n, N = (size_t)nodes;
    size_t count = 0;
    MPC_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(mpc)) + padded(count * sizeof(real)) + program;
}

mpc *mpc_open(const mpc_model *model, int coordinates, int actuators, int tasks, int nodes, void *memory)
{
    const size_t size = mpc_size(coordinates, actuators, tasks, nodes);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    mpc *s = memory;
    s->model = *model;
    const size_t n = s->n = (size_t)coordinates, a = s->a = (size_t)actuators, N = s->N = (size_t)nodes;
    const size_t r = s->r = tasks ? (size_t)tasks : n;
    s->has_tasks = tasks != 0;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
    MPC_ARRAYS(NAMED_PLACE)
    void *rest = (char *)memory + (size - stage_qp_size(nodes, 2 * coordinates, actuators));
    s->program = stage_qp_open(nodes, 2 * coordinates, actuators, rest);
    size_t length;
#define FIND(name) s->qp.name = stage_qp_array(s->program, #name, &length);
    QP_ARRAYS(FIND)
#undef FIND
    return s;
}

real *mpc_array(mpc *s, const char *name, size_t *length)
{
    const size_t n = s->n, a = s->a, r = s->r, N = s->N;
    if (!strcmp(name, "planned")) return *length = 1 + (N + 1) * 2 * n + N * a, s->planned;
    MPC_ARRAYS(NAMED_FIND)
    return NULL;
}

void mpc_reset(mpc *s)
{
    s->planned[0] = 0;
}
