/* What acts from outside: generalised forces of the caller, and wrenches on points of frames. */
#include "state.h"

int core_push(core *c, int32_t count, const int32_t *frame, const real *point, const real *wrench)
{
    for (int32_t k = 0; k < count; k++)
        if (frame[k] < -1 || frame[k] >= c->blob.counts.dofs) return 1 + k;
    c->pushes = count, c->push_frame = frame, c->push_point = point, c->push_wrench = wrench;
    return 0;
}

static int is_nothing(const real wrench[6])
{
    for (int k = 0; k < 6; k++)
        if (wrench[k] != 0) return 0;
    return 1;
}

/* J'w: every motion between the point and the world feels it. */
static void push(core *c, int32_t frame, const real local[3], const real wrench[6])
{
    real point[3], velocity[3];
    tree_point(c, frame, local, point);
    for (int32_t i = frame; i >= 0; i = c->blob.parent[i]) {
        tree_point_velocity(c, i, point, velocity);
        real felt = dot3(velocity, wrench);
        if (c->blob.motion[i] == ROTATION) felt += dot3(c->axis + 3 * i, wrench + 3);
        c->outer[c->blob.coordinate[i]] += felt;
    }
}

void pushes_add(core *c, const real *extra)
{
    for (int32_t j = 0; j < c->blob.counts.dofs; j++) c->outer[j] = extra ? extra[j] : 0;
    for (int32_t k = 0; k < c->pushes; k++)
        if (!is_nothing(c->push_wrench + 6 * k))
            push(c, c->push_frame[k], c->push_point + 3 * k, c->push_wrench + 6 * k);
}
