/* The handle of a control loop: its memory and its arrays. */
#include "loop_state.h"

#include <string.h>

size_t control_loop_size(int coordinates, int muscles, int tasks)
{
    const size_t law = computed_torque_size(coordinates, muscles, tasks);
    if (!law) return 0;
    const size_t n = (size_t)coordinates, m = (size_t)muscles, r = tasks ? (size_t)tasks : n;
    size_t count = 0;
    LOOP_ARRAYS(NAMED_LENGTH)
    return padded(sizeof(control_loop)) + padded(law) + count * sizeof(real);
}

control_loop *control_loop_open(const control_robot *robot, int coordinates, int muscles, int tasks,
                                void *memory)
{
    const size_t size = control_loop_size(coordinates, muscles, tasks);
    if (!size || !memory || (uintptr_t)memory % 8) return NULL;
    memset(memory, 0, size);
    control_loop *s = memory;
    s->robot = *robot;
    char *rest = (char *)memory + padded(sizeof *s);
    s->law = computed_torque_open(coordinates, muscles, tasks, rest);
    rest += padded(computed_torque_size(coordinates, muscles, tasks));
    const size_t n = s->law->n, m = s->law->m, r = s->law->r;
    real *at = (real *)(void *)rest;
    LOOP_ARRAYS(NAMED_PLACE)
    return s;
}

void control_loop_set_law(control_loop *s, const control_law *law)
{
    s->custom = *law;
}

static size_t remembered(const control_loop *s)
{
    return 3 * s->law->m + s->law->r + 4 * s->law->n + 1;
}

real *control_loop_array(control_loop *s, const char *name, size_t *length)
{
    const size_t n = s->law->n, m = s->law->m, r = s->law->r;
    if (!strcmp(name, "remembered")) return *length = remembered(s), s->acting;
    LOOP_ARRAYS(NAMED_FIND)
    return computed_torque_array(s->law, name, length);
}

void control_loop_reset(control_loop *s)
{
    computed_torque_reset(s->law);
    memset(s->acting, 0, remembered(s) * sizeof(real));
    memcpy(s->acting, s->law->forces, s->law->m * sizeof(real));
    memcpy(s->coming, s->law->forces, s->law->m * sizeof(real));
}
