/* Muscles with more than fixed points, branches and single wraps: conditional points, points that move on
   their links, lengths proportional to coordinates, wraps with OpenSim's rule, several with MuJoCo's.

   Point k has an activity s_k: 1, 0, or a value between in a smoothed transition. A straight path from point
   i to j is weighted by s_i s_j times the product of 1 - s_k over the points between, and divided by the
   divisor of its branch. With activities of 0 and 1 this is the path through the active points. */
#include "routed.h"

#include "../../kinematics/tree.h"
#include "../../math/elementary.h"
#include "../../math/quintic_step.h"
#include "../place.h"
#include "route_wraps.h"
#include "../span.h"

#include <math.h>
#include <string.h>

/* ------------------------------------------------------------------------------ moving points */

/* Evaluate the cubic piece of a function at x: f, and its slope. */
static real cubic_at(const blob_view *blob, int32_t first, int32_t count, real x, real *slope)
{
    int32_t low = 0, high = count;
    while (high - low > 1) {
        const int32_t middle = (low + high) / 2;
        if (value_of(x) < value_of(blob->piece[5 * (first + middle)]))
            high = middle;
        else
            low = middle;
    }
    const real *p = blob->piece + 5 * (first + low), D = x - p[0];
    *slope = p[2] + D * (2 * p[3] + D * 3 * p[4]);
    return p[1] + D * (p[2] + D * (p[3] + D * p[4]));
}

void routed_place(core *c)
{
    const blob_view *blob = &c->blob;
    for (int32_t k = 0; k < blob->counts.moves;) {
        const int32_t point = blob->move_point[k];
        real local[3];
        memcpy(local, blob->point_position + 3 * point, sizeof local);
        for (; k < blob->counts.moves && blob->move_point[k] == point; k++) {
            const real q = c->at[blob->move_coordinate[k]], x = smaller(larger(q, blob->move_low[k]), blob->move_high[k]);
            const real f = cubic_at(blob, blob->move_first[k], blob->move_pieces[k], x, c->move_slope + k);
            if (value_of(q) != value_of(x)) c->move_slope[k] = 0;
            for (int j = 0; j < 3; j++) local[j] += f * blob->move_axis[3 * k + j];
        }
        tree_point(c, blob->point_frame[point], local, c->point + 3 * point);
    }
}

/* Add the contribution of the motion of a point on its link, if the path ends at it along u. */
static void add_own_motion(const core *c, const route *r, int32_t point, const real u[3], real *row)
{
    for (int32_t k = r->moves; k < c->blob.counts.moves && c->blob.move_point[k] <= point; k++) {
        if (c->blob.move_point[k] != point) continue;
        real axis[3];
        tree_direction(c, c->blob.point_frame[point], c->blob.move_axis + 3 * k, axis);
        row[c->blob.move_coordinate[k]] += dot3(u, axis) * c->move_slope[k];
    }
}

/* ------------------------------------------------------------------------------ active points */

static real condition_share(const core *c, int32_t k, real *slope)
{
    const blob_view *blob = &c->blob;
    const real q = c->at[blob->condition_coordinate[k]], width = blob->condition_smoothing[k];
    const real below = blob->condition_low[k] - q, above = q - blob->condition_high[k], out = larger(below, above);
    *slope = 0;
    if (value_of(out) <= 0) return 1;
    if (value_of(out) >= value_of(width)) return 0;
    const real x = 1 - out / width;
    *slope = quintic_step_rate(x) * ((value_of(below) > 0 ? 1 : -1) / width);
    return quintic_step(x);
}

static void find_shares(core *c, const route *r, progress *at)
{
    const blob_view *blob = &c->blob;
    for (int32_t k = r->first; k < r->end; k++) c->point_share[k] = 1;
    for (; at->condition < blob->counts.conditions && blob->condition_point[at->condition] < r->end; at->condition++)
        c->point_share[blob->condition_point[at->condition]] =
            condition_share(c, at->condition, c->condition_slope + at->condition);
}

/* ------------------------------------------------------------------------------ paths between points */

/* Add the derivatives of a path, weighted by a factor. */
static void add_ends(const core *c, const route *r, int32_t i, int32_t j, const path_between *way, real *row)
{
    real u[3];
    for (int k = 0; k < 3; k++) u[k] = -r->factor * way->entering[k];
    add_own_motion(c, r, i, u, row);
    for (int k = 0; k < 3; k++) u[k] = r->factor * way->leaving[k];
    add_own_motion(c, r, j, u, row);
}

static void add_straight(const core *c, const route *r, int32_t i, int32_t j, path_between *way, real *row)
{
    const real *A = c->point + 3 * i, *B = c->point + 3 * j;
    real u[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]};
    memset(way->entering, 0, sizeof way->entering);
    memset(way->leaving, 0, sizeof way->leaving);
    way->length = j == i + 1 ? c->fixed_length[i] : -1;
    if (value_of(way->length) >= 0) return;
    way->length = sqrt(dot3(u, u));
    if (way->length == 0) return;
    for (int k = 0; k < 3; k++) way->entering[k] = way->leaving[k] = u[k] / way->length, u[k] = r->factor * way->leaving[k];
    span_add(c, u, A, c->blob.point_frame[i], B, c->blob.point_frame[j], row);
}

/* Add the derivative of the weight of a straight path, times its length. */
static void add_shares(const core *c, const route *r, int32_t i, int32_t j, real length, real *row)
{
    for (int32_t k = r->conditions; k < c->blob.counts.conditions && c->blob.condition_point[k] <= j; k++) {
        const int32_t point = c->blob.condition_point[k];
        if (point < i || c->condition_slope[k] == 0) continue;
        real others = 1;
        for (int32_t p = i; p <= j; p++) {
            const real share = c->point_share[p];
            if (p != point) others *= p == i || p == j ? share : 1 - share;
        }
        const real slope = (point == i || point == j ? 1 : -1) * others * c->condition_slope[k];
        row[c->blob.condition_coordinate[k]] += slope * length;
    }
}

/* Add all straight paths from point i on, up to the next fully active point. */
static real add_shared(core *c, route *r, int32_t i, int32_t stop, real divisor, real *row)
{
    real sum = 0, left = c->point_share[i];
    for (int32_t j = i + 1; j < stop && value_of(left) > 0; left *= 1 - c->point_share[j], j++) {
        if (c->point_share[j] == 0) continue;
        path_between way;
        const real share = left * c->point_share[j];
        r->factor = share / divisor;
        add_straight(c, r, i, j, &way, row);
        add_ends(c, r, i, j, &way, row);
        add_shares(c, r, i, j, way.length / divisor, row);
        sum += share * way.length;
    }
    return sum / divisor;
}

/* Add the path from point i to the next active point, over its wraps. */
static real add_wrapped(core *c, route *r, int32_t i, int32_t j, real divisor, real *row, int is_traced)
{
    path_between way;
    if (!is_traced && !r->is_changing && is_rigid(c, i, j, r->wraps)) return 0;
    r->factor = 1 / divisor;
    if (!route_wraps_over(c, r, i, j, &way, row, is_traced)) add_straight(c, r, i, j, &way, row);
    add_ends(c, r, i, j, &way, row);
    return way.length / divisor;
}

static int32_t next_in_use(const core *c, int32_t i, int32_t stop)
{
    for (i++; i < stop && c->point_share[i] == 0; i++);
    return i;
}

/* Add one branch. */
static real add_branch(core *c, route *r, int32_t start, int32_t stop, real divisor, real *row, int is_traced)
{
    real length = 0;
    for (int32_t i = next_in_use(c, start - 1, stop); i < stop; i = next_in_use(c, i, stop)) {
        const int32_t j = next_in_use(c, i, stop);
        if (!r->wrap_count)
            length += add_shared(c, r, i, stop, divisor, row);
        else if (j < stop)
            length += add_wrapped(c, r, i, j, divisor, row, is_traced);
    }
    return length;
}

real routed_add(core *c, int32_t m, int32_t first, progress *at, real *row, int is_traced)
{
    const blob_view *blob = &c->blob;
    route r = {.first = first, .end = first + blob->muscle_points[m], .wraps = at->wrap,
               .conditions = at->condition, .moves = at->move};
    while (at->wrap < blob->counts.wraps && blob->wrap_point[at->wrap] < r.end) at->wrap++;
    while (at->move < blob->counts.moves && blob->move_point[at->move] < r.end) at->move++;
    r.wrap_count = at->wrap - r.wraps;
    find_shares(c, &r, at);
    r.is_changing = at->condition > r.conditions || at->move > r.moves;
    if (!(HAS_TANGENT && c->moving)) route_wraps_choose(c, &r); /* otherwise as in the plain core */
    real length = 0, divisor = 1;
    for (int32_t start = first; start < r.end;) {
        if (at->branch < blob->counts.branches && blob->branch_point[at->branch] == start)
            divisor = blob->branch_divisor[at->branch++];
        const int is_more = at->branch < blob->counts.branches && blob->branch_point[at->branch] < r.end;
        const int32_t stop = is_more ? blob->branch_point[at->branch] : r.end;
        length += add_branch(c, &r, start, stop, divisor, row, is_traced);
        start = stop;
    }
    for (; at->term < blob->counts.path_terms && blob->path_term_muscle[at->term] == m; at->term++) {
        const int32_t j = blob->path_term_coordinate[at->term];
        length += blob->path_term_factor[at->term] * c->at[j], row[j] += blob->path_term_factor[at->term];
    }
    return length;
}

/* ------------------------------------------------------------------------------ selection of muscles */

/* Return whether a wrap is not the only one of its segment, with our rule or MuJoCo's. */
static int needs_routing(const blob_view *blob, int32_t w)
{
    const int32_t *point = blob->wrap_point + w;
    if (blob->wrap_rule[w] != RULE_MUJOCO) return blob->wrap_rule[w] != RULE_TAUT;
    return (w > 0 && point[-1] == *point) || (w + 1 < blob->counts.wraps && point[1] == *point);
}

/* Return whether one of the wraps before wrap w would lie between the last branch and the one from `point` on. */
static int has_wrap_before(const blob_view *blob, int32_t w, int32_t point)
{
    while (w-- > 0 && blob->wrap_point[w] >= point - 1)
        if (blob->wrap_point[w] == point - 1) return 1;
    return 0;
}

void routed_prepare(core *c)
{
    const blob_view *blob = &c->blob;
    int32_t first = 0, w = 0, condition = 0, move = 0, branch = 0, term = 0;
    for (int32_t m = 0; m < blob->counts.muscles; m++) {
        const int32_t end = first + blob->muscle_points[m];
        int is_routed = blob->muscle_points[m] < 2;
        for (; w < blob->counts.wraps && blob->wrap_point[w] < end; w++) is_routed |= needs_routing(blob, w);
        for (; condition < blob->counts.conditions && blob->condition_point[condition] < end; condition++) is_routed = 1;
        for (; move < blob->counts.moves && blob->move_point[move] < end; move++) is_routed = 1;
        for (; branch < blob->counts.branches && blob->branch_point[branch] < end; branch++)
            is_routed |= has_wrap_before(blob, w, blob->branch_point[branch]);
        for (; term < blob->counts.path_terms && blob->path_term_muscle[term] == m; term++) is_routed = 1;
        c->is_routed[m] = is_routed;
        for (int32_t k = first; k < end; k++) c->point_share[k] = 1;
        first = end;
    }
    for (w = 0; w < blob->counts.wraps; w++) c->wrap_before[w] = blob->wrap_point[w];
}
