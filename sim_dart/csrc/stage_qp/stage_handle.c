/* The handle of a program over stages: its memory and its arrays. */
#include "stage_state.h"

#include <string.h>

enum { MAX_STAGES = 4096, MAX_SIZE = 512 };

size_t stage_qp_size(int stages, int states, int controls)
{
    if (stages < 1 || states < 1 || controls < 1) return 0;
    if (stages > MAX_STAGES || states > MAX_SIZE || controls > MAX_SIZE) return 0;
    const size_t N = (size_t)stages, x = (size_t)states, u = (size_t)controls, w = x + u, total = N * w + x;
    size_t count = 0;
    STAGE_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(stage_qp)) + count * sizeof(real);
}

stage_qp *stage_qp_open(int stages, int states, int controls, void *memory)
{
    const size_t size = stage_qp_size(stages, states, controls);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    stage_qp *s = memory;
    const size_t N = s->N = (size_t)stages, x = s->x = (size_t)states, u = s->u = (size_t)controls;
    const size_t w = s->w = x + u, total = s->total = N * w + x;
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
    STAGE_ARRAYS(NAMED_PLACE)
    for (size_t i = 0; i < total; i++) s->low[i] = -INFINITY, s->high[i] = INFINITY;
    s->tolerance[0] = PRECISE(1e-10, 1e-5f), s->tolerance[1] = PRECISE(1e-9, 1e-5f);
    return s;
}

real *stage_qp_array(stage_qp *s, const char *name, size_t *length)
{
    const size_t N = s->N, x = s->x, u = s->u, w = s->w, total = s->total;
    STAGE_ARRAYS(NAMED_FIND)
    return NULL;
}

int stage_qp_iterations(const stage_qp *s)
{
    return s->steps;
}
