/* The handle: its memory and its arrays. */
#include "state.h"

#include <string.h>

static int is_size(int count)
{
    return count >= 1 && count <= DUAL_NEWTON_LARGEST_SIZE;
}

/* The arrays after a handle begin at a multiple of 8 bytes, also where pointers have 4 bytes. */
static const size_t HANDLE_SIZE = (sizeof(dual_newton) + 7u) / 8u * 8u;

size_t dual_newton_size(int variables, int rows)
{
    if (!is_size(variables) || !is_size(rows)) return 0;
    const size_t n = (size_t)variables, m = (size_t)rows;
    size_t size = HANDLE_SIZE;
#define ADD_SIZE(type, name, length) size += sizeof(type) * (length);
    STATE_ARRAYS(ADD_SIZE)
#undef ADD_SIZE
    return size;
}

dual_newton *dual_newton_open(int variables, int rows, void *memory)
{
    const size_t size = dual_newton_size(variables, rows);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    dual_newton *s = memory;
    const size_t n = s->n = (size_t)variables, m = s->m = (size_t)rows;
    char *at = (char *)memory + HANDLE_SIZE;
#define PLACE(type, name, length) s->name = (type *)(void *)at, at += sizeof(type) * (length);
    STATE_ARRAYS(PLACE)
#undef PLACE
    return s;
}

real *dual_newton_array(dual_newton *s, const char *name, size_t *length)
{
    const size_t n = s->n, m = s->m;
    const struct {
        const char *name;
        real *array;
        size_t length;
    } arrays[] = {
        {"H_diagonal", s->H_diagonal, n}, {"g", s->g, n},
        {"lb", s->lb, n},                 {"ub", s->ub, n},
        {"A", s->A, n * m},               {"b", s->b, m},
        {"softness", s->softness, m},     {"start", s->start, m},
        {"x", s->x, n},                   {"multipliers", s->multipliers, m},
        {"slack", s->slack, m},           {"residuals", s->residuals, 2},
    };
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        if (!strcmp(arrays[k].name, name)) return *length = arrays[k].length, arrays[k].array;
    return NULL;
}

int dual_newton_steps(const dual_newton *s)
{
    return (int)s->steps;
}
