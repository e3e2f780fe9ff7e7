#include "structure.h"

#include "../../math/vectors.h"

#include <math.h>
#include <string.h>

/* Compute the lengths of the segments between points that are fixed to the same frame; -1 for all others. */
static void find_fixed_segments(core *c)
{
    const blob_view *blob = &c->blob;
    for (int32_t k = 0; k < blob->counts.points; k++) {
        const real *a = blob->point_position + 3 * k, *b = a + 3;
        c->fixed_length[k] = -1;
        if (k + 1 == blob->counts.points || blob->point_frame[k] != blob->point_frame[k + 1]) continue;
        const real d[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
        c->fixed_length[k] = sqrt(dot3(d, d));
    }
    for (int32_t i = 0; i < blob->counts.moves; i++) {
        const int32_t k = blob->move_point[i];
        c->fixed_length[k] = -1;
        if (k > 0) c->fixed_length[k - 1] = -1;
    }
}

/* ------------------------------------------------------------------------------ columns of L */

/* First items of a muscle in the lists of the blob. */
typedef struct {
    int32_t point, wrap, condition, move, term;
} items;

/* Count a frame and the frames that carry it. */
static void count_frame(core *c, int32_t frame)
{
    for (; frame >= 0; frame = c->blob.parent[frame]) c->drive[frame] += 1;
}

/* Count, for each frame, the points and surfaces of a muscle that it carries; advance the items up to via point
   `end`. Return their number. */
static int32_t count_carried(core *c, items *at, int32_t end)
{
    const blob_view *b = &c->blob;
    int32_t count = end - at->point;
    memset(c->drive, 0, (size_t)b->counts.frames * sizeof(real));
    for (; at->point < end; at->point++) count_frame(c, b->point_frame[at->point]);
    for (; at->wrap < b->counts.wraps && b->wrap_point[at->wrap] < end; at->wrap++, count++)
        count_frame(c, b->surface_frame[b->wrap_surface[at->wrap]]);
    return count;
}

/* Mark the variables that a path depends on: those between its points and surfaces, and those of its conditions,
   moving points and terms. A frame that carries all points and surfaces of the path only moves it as a whole. */
static void mark_variables(core *c, int32_t m, items *at, real *is_used)
{
    const blob_view *b = &c->blob;
    const int32_t end = at->point + b->muscle_points[m], count = count_carried(c, at, end);
    memset(is_used, 0, (size_t)b->counts.variables * sizeof(real));
    for (int32_t i = 0; i < b->counts.frames; i++)
        if (c->drive[i] != 0 && c->drive[i] != count) is_used[b->coordinate[i]] = 1;
    for (; at->condition < b->counts.conditions && b->condition_point[at->condition] < end; at->condition++)
        is_used[b->condition_coordinate[at->condition]] = 1;
    for (; at->move < b->counts.moves && b->move_point[at->move] < end; at->move++)
        is_used[b->move_coordinate[at->move]] = 1;
    for (; at->term < b->counts.path_terms && b->path_term_muscle[at->term] == m; at->term++)
        is_used[b->path_term_coordinate[at->term]] = 1;
    for (int32_t k = b->counts.variables, t = b->counts.terms; k-- > b->counts.dofs;)
        for (int32_t i = b->variable_terms[k]; i-- > 0;)
            if (is_used[k] != 0) is_used[b->term_source[--t]] = 1;
            else --t;
}

static void find_columns(core *c)
{
    items at = {0, 0, 0, 0, 0};
    real *is_used = c->is_driven ? c->row : c->load;
    for (int32_t m = 0; m < c->blob.counts.muscles; m++) {
        int32_t first = c->blob.counts.dofs, end = 0;
        mark_variables(c, m, &at, is_used);
        for (int32_t j = 0; j < c->blob.counts.dofs; j++)
            if (is_used[j] != 0) first = j < first ? j : first, end = j + 1;
        c->column_first[m] = first, c->column_end[m] = end;
    }
}

void structure_prepare(core *c)
{
    find_fixed_segments(c);
    find_columns(c);
}
