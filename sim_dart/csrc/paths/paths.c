/* Muscle paths through via points, over surfaces and off pulleys: l and L = dl/dq.

   A path is a chain of bodies with a straight span between neighbours. l' is the sum over the spans of
   u.(velocity of the next body - velocity of the previous body), at a point on the span, with u along it.
   The contact point on a surface also moves, but this does not change the length (envelope theorem). */
#include "paths.h"

#include "../cable_friction/bends.h"

#include "../kinematics/tree.h"
#include "../kinematics/joint_variables.h"
#include "../numbers/real_functions.h"
#include "../optional_parts.h"
#include "multi_wrap.h"
#include "place.h"
#include "routed/route_wraps.h"
#include "routed/routed.h"
#include "routed/wrap_rules.h"
#include "span.h"
#include "structure/straight.h"
#include "structure/structure.h"
#include "wrap.h"
#include "wrap_simd.h"

#include <math.h>
#include <string.h>

/* Compute the surface of the only wrap of a segment and the way around it. Return 0 if the rule of the wrap
   excludes a contact. */
static inline int find_way(const core *c, int32_t k, int32_t w, wrap_surface *surface, wrap_way *way)
{
    const real *A = c->point + 3 * k, *B = A + 3;
    *surface = wrapped_surface(c, w);
    *way = wrap_way_of(c, w);
    if (c->wrap_is_inside[w] != 0) way->side = WRAP_INSIDE;
    if (!USES_ROUTES || c->blob.wrap_rule[w] == RULE_TAUT || way->side == WRAP_INSIDE) return 1;
    return route_wraps_rule(c, w, A, B, surface, way) != RULE_STRAIGHT;
}

/* Compute the contact of a segment over one surface. */
static void trace_wrap(core *c, int32_t k, int32_t w)
{
    const real *A = c->point + 3 * k, *B = A + 3;
    real *numbers = c->wrap_contact + CONTACT_NUMBERS * w;
    wrap_surface surface;
    wrap_way way;
    contact passed;
    numbers[CONTACT_NUMBERS - 1] = 0;
    if (!find_way(c, k, w, &surface, &way)) return;
    wrap_over(&surface, &way, A, B, &passed);
    write_contact(numbers, &passed, A, B);
}

/* Add a segment over one surface, computed separately. */
static real add_wrap(core *c, int32_t k, int32_t w, real *row)
{
    const real *A = c->point + 3 * k, *B = A + 3;
    const int32_t frame = c->blob.surface_frame[c->blob.wrap_surface[w]];
    wrap_surface surface;
    wrap_way way;
    pull over;
    if (!find_way(c, k, w, &surface, &way)) return add_segment(c, k, row);
    const int ends = wrap_ends(&c->blob, w);
    if (!wrap_pull(&surface, &way, A, B, ends, &over)) return add_segment(c, k, row);
    if (ends & ENTERING) add_span(c, over.entering, A, c->blob.point_frame[k], A, frame, row);
    if (ends & LEAVING) add_span(c, over.leaving, B, frame, B, c->blob.point_frame[k + 1], row);
    return over.length;
}

/* Add a segment that was computed in parallel with others, with little code per muscle. */
static inline real add_lane(const core *c, int32_t k, int32_t w, int32_t i, const wrap_lanes *lanes, real *row)
{
    const real *A = c->point + 3 * k, *B = A + 3;
    const int32_t *ends = c->blob.point_frame + k, frame = c->blob.surface_frame[c->blob.wrap_surface[w]];
    if (ends[0] != frame) {
        const real u[3] = {lanes->entering[0][i], lanes->entering[1][i], lanes->entering[2][i]};
        add_span(c, u, A, ends[0], A, frame, row);
    }
    if (ends[1] != frame) {
        const real u[3] = {lanes->leaving[0][i], lanes->leaving[1][i], lanes->leaving[2][i]};
        add_span(c, u, B, frame, B, ends[1], row);
    }
    return lanes->length[i];
}

/* Return whether the segment is the straight line between two via points. */
static int is_free(const sequence_part *parts, int count, const real *A, const real *B)
{
    for (int i = 0; i < count; i++)
        if (!parts[i].surface || parts[i].way.turns ||
            !wrap_is_clear(parts[i].surface, &parts[i].way, A, B))
            return 0;
    return 1;
}

/* Add a segment off a pulley or over several surfaces. */
static real add_sequence(core *c, int32_t k, progress at, int32_t surfaces, int32_t pulleys, real *row,
                         int is_traced)
{
    sequence_part parts[MAX_SEQUENCE + 1];
    wrap_surface placed[MAX_SEQUENCE];
    contact contacts[MAX_SEQUENCE + 1];
    real points[MAX_SEQUENCE + 2][3];
    int32_t frames[MAX_SEQUENCE + 3];
    const int count = (int)(surfaces + pulleys);
    memset(parts, 0, sizeof parts);
    memset(contacts, 0, sizeof contacts);
    frames[0] = c->blob.point_frame[k];
    if (pulleys) {
        tree_direction(c, frames[0], c->blob.pulley_direction + 3 * at.pulley, parts[0].v);
        parts[0].radius = c->blob.pulley_radius[at.pulley];
        frames[1] = frames[0];
    }
    for (int32_t i = 0; i < surfaces; i++) {
        const int32_t s = c->blob.wrap_surface[at.wrap + i];
        placed[i] = wrapped_surface(c, at.wrap + i);
        parts[pulleys + i].surface = placed + i;
        parts[pulleys + i].way = wrap_way_of(c, at.wrap + i);
        frames[pulleys + i + 1] = c->blob.surface_frame[s];
    }
    frames[count + 1] = c->blob.point_frame[k + 1];
    memcpy(points[0], c->point + 3 * k, sizeof points[0]);
    memcpy(points[count], c->point + 3 * (k + 1), sizeof points[count]);
    const int is_straight = is_free(parts, count, points[0], points[count]);
    const real length = is_straight ? add_segment(c, k, row) : sequence_solve(parts, count, points, contacts);
    for (int i = 0; i <= count && !is_straight; i++) {
        const real *u = i < count ? contacts[i].pull.entering : contacts[i - 1].pull.leaving;
        add_span(c, u, points[i], frames[i], points[i], frames[i + 1], row);
    }
    for (int32_t i = 0; i < surfaces && is_traced; i++)
        write_contact(c->wrap_contact + CONTACT_NUMBERS * (at.wrap + i), contacts + pulleys + i, points[pulleys + i],
                      points[pulleys + i + 1]);
    if (is_traced && pulleys)
        write_contact(c->pulley_contact + CONTACT_NUMBERS * at.pulley, contacts, points[0], points[1]);
    return length;
}

/* Return the lane of the next wrap, at via point k; -1 if it is computed separately. */
static inline int32_t next_lane(const core *c, int32_t k, progress *at, wrap_lanes *lanes)
{
    if (at->wrap >= c->blob.counts.wraps || c->blob.wrap_point[at->wrap] != k || c->wrap_is_special[at->wrap] != 0) return -1;
    const int32_t lane = at->lane++;
    if (lane >= lanes->first + lanes->count) wrap_simd_fill(c, lane, lanes);
    return lanes->is_alone[lane - lanes->first] == 0 ? lane - lanes->first : -1;
}

/* Add a segment with wraps or a pulley; `at` is the index of its first wrap and its pulley in their lists. */
static real add_curved_segment(core *c, int32_t k, progress *at, wrap_lanes *lanes, real *row, int is_traced)
{
    const blob_view *blob = &c->blob;
    const progress begin = *at;
    const int32_t lane = next_lane(c, k, at, lanes);
    if (lane >= 0) {
        if (is_traced) trace_wrap(c, k, begin.wrap);
        at->wrap++;
        return add_lane(c, k, begin.wrap, lane, lanes, row);
    }
    while (at->wrap < blob->counts.wraps && blob->wrap_point[at->wrap] == k) at->wrap++;
    at->pulley += at->pulley < blob->counts.pulleys && blob->pulley_point[at->pulley] == k;
    const int32_t surfaces = at->wrap - begin.wrap, pulleys = at->pulley - begin.pulley;
    if (!USES_SEQUENCES || (surfaces == 1 && !pulleys)) {
        if (is_traced) trace_wrap(c, k, begin.wrap);
        return add_wrap(c, k, begin.wrap, row);
    }
    return add_sequence(c, k, begin, surfaces, pulleys, row, is_traced);
}

/* Return the next via point with a wrap or a pulley after it. */
static inline int32_t next_curved_segment(const blob_view *blob, const progress *at)
{
    int32_t next = blob->counts.points;
    if (at->wrap < blob->counts.wraps) next = blob->wrap_point[at->wrap];
    if (at->pulley < blob->counts.pulleys && blob->pulley_point[at->pulley] < next)
        next = blob->pulley_point[at->pulley];
    return next;
}

/* Compute the centre and axis of a surface, and the x axis of an ellipsoid. */
static inline void place_surface(const core *c, int32_t s)
{
    const real *centre = c->blob.surface_centre + 3 * s, *axis = c->blob.surface_axis + 3 * s;
    const int32_t frame = c->blob.surface_frame[s];
    real *place = c->surface_place + 6 * s;
    if (USES_ELLIPSOIDS && c->blob.surface_kind[s] == SURFACE_ELLIPSOID)
        tree_direction(c, frame, c->blob.surface_across + 3 * s, c->surface_across + 3 * s);
    if (frame < 0) {
        memcpy(place, centre, 3 * sizeof(real));
        memcpy(place + 3, axis, 3 * sizeof(real));
        return;
    }
    const real *R = c->rotation + 9 * frame, *origin = c->origin + 3 * frame;
    for (int k = 0; k < 3; k++) {
        place[k] = origin[k] + dot3(R + 3 * k, centre);
        place[3 + k] = dot3(R + 3 * k, axis);
    }
}

static void place_all(core *c)
{
    const blob_view *blob = &c->blob;
    straight_place(c);
    for (int32_t s = 0; s < blob->counts.surfaces; s++) place_surface(c, s);
    if (USES_ROUTES && blob->counts.moves) routed_place(c);
}

/* Position of the iteration over all paths. */
typedef struct {
    progress at;
    int32_t next; /* next via point with a wrap or a pulley after it */
    int is_traced;
    wrap_lanes lanes;
} walker;

/* Pass the wraps and pulleys after via points before `end`. */
static void pass_wraps(const core *c, walker *w, int32_t end)
{
    const blob_view *b = &c->blob;
    progress *at = &w->at;
    for (; at->wrap < b->counts.wraps && b->wrap_point[at->wrap] < end; at->wrap++)
        at->lane += c->wrap_is_special[at->wrap] == 0;
    while (at->pulley < b->counts.pulleys && b->pulley_point[at->pulley] < end) at->pulley++;
    w->next = next_curved_segment(b, at);
}

/* Add the segments from via point k to `last`. */
static inline real add_part(core *c, walker *w, int32_t k, int32_t last, real *row)
{
    real length = 0;
    for (; k < last; k++) {
        if (!w->is_traced && is_rigid(c, k, k + 1, w->at.wrap)) {
            pass_wraps(c, w, k + 1);
            continue;
        }
        if (!(USES_WRAPS || USES_SEQUENCES) || k != w->next) {
            const real fixed = c->fixed_length[k];
            length += value_of(fixed) >= 0 ? fixed : add_segment(c, k, row);
            continue;
        }
        length += add_curved_segment(c, k, &w->at, &w->lanes, row, w->is_traced);
        w->next = next_curved_segment(&c->blob, &w->at);
    }
    return length;
}

/* Add the branches of a muscle with the via points from `first` to before `end`. */
static real add_branches(core *c, walker *w, int32_t first, int32_t end, real *row)
{
    const blob_view *blob = &c->blob;
    const size_t size = (size_t)blob->counts.variables;
    real length = 0, divisor = 1;
    for (int32_t start = first, stop; start < end; start = stop) {
        progress *at = &w->at;
        if (at->branch < blob->counts.branches && blob->branch_point[at->branch] == start)
            divisor = blob->branch_divisor[at->branch++];
        const int is_more = at->branch < blob->counts.branches && blob->branch_point[at->branch] < end;
        stop = is_more ? blob->branch_point[at->branch] : end;
        memset(c->branch_row, 0, size * sizeof(real));
        length += add_part(c, w, start, stop - 1, c->branch_row) / divisor;
        for (size_t j = 0; j < size; j++) row[j] += c->branch_row[j] / divisor;
    }
    return length;
}

static inline real add_muscle(core *c, walker *w, int32_t m, int32_t first, real *row)
{
    const blob_view *blob = &c->blob;
    const int32_t end = first + blob->muscle_points[m];
    if (USES_ROUTES && c->is_routed[m] != 0) {
        const real length = routed_add(c, m, first, &w->at, row, w->is_traced);
        w->next = next_curved_segment(blob, &w->at);
        return length;
    }
    if (USES_ROUTES && w->at.branch < blob->counts.branches && blob->branch_point[w->at.branch] < end)
        return add_branches(c, w, first, end, row);
    return add_part(c, w, first, end - 1, row);
}

/* Return whether a muscle keeps its length while only one coordinate moves. */
static inline int is_still(const core *c, int32_t m)
{
    const int32_t j = c->moving - 1;
    return HAS_TANGENT && c->moving && (j < index_of(c->column_first[m]) || j >= index_of(c->column_end[m]));
}

/* Pass a muscle whose via points are before `end`. */
static void pass_muscle(const core *c, walker *w, int32_t m, int32_t end)
{
    const blob_view *b = &c->blob;
    progress *at = &w->at;
    pass_wraps(c, w, end);
    while (at->branch < b->counts.branches && b->branch_point[at->branch] < end) at->branch++;
    while (at->condition < b->counts.conditions && b->condition_point[at->condition] < end) at->condition++;
    while (at->move < b->counts.moves && b->move_point[at->move] < end) at->move++;
    while (at->term < b->counts.path_terms && b->path_term_muscle[at->term] == m) at->term++;
}

/* Return a number with the tangent of another one. */
static inline real with_tangent_of(real x, real other)
{
    return value_of(x) + (other - value_of(other));
}

static void walk(core *c, int is_traced)
{
    const blob_view *blob = &c->blob;
    const size_t dofs = (size_t)blob->counts.dofs;
    walker w;
    memset(&w.at, 0, sizeof w.at);
    w.is_traced = is_traced, w.lanes.first = w.lanes.count = 0;
    w.next = next_curved_segment(blob, &w.at);
    for (int32_t m = 0, k = 0; m < blob->counts.muscles; k += blob->muscle_points[m], m++) {
        const int has_tangents_only = HAS_TANGENT && c->moving && !c->is_driven; /* without rigid parts */
        real *J = c->jacobian + (size_t)m * dofs, *row = c->is_driven ? c->row : has_tangents_only ? c->load : J;
        if (is_still(c, m)) {
            pass_muscle(c, &w, m, k + blob->muscle_points[m]);
            c->lengths[m] = value_of(c->lengths[m]);
            for (size_t j = 0; j < dofs; j++) J[j] = value_of(J[j]);
            continue;
        }
        memset(row, 0, (c->is_driven ? (size_t)blob->counts.variables : dofs) * sizeof(real));
        const real length = add_muscle(c, &w, m, k, row);
        c->lengths[m] = has_tangents_only ? with_tangent_of(c->lengths[m], length) : length;
        for (size_t j = 0; j < dofs && has_tangents_only; j++) J[j] = with_tangent_of(J[j], row[j]);
        if (c->is_driven) variables_fold(c, row, J);
    }
}

void paths_prepare(core *c)
{
    structure_prepare(c);
    c->is_straight = straight_applies(c);
    for (int32_t w = 0; w < c->blob.counts.wraps; w++) c->stored_path[PATH_NUMBERS * w] = NAN;
    if (USES_ROUTES) routed_prepare(c);
    if (USES_WRAPS) wrap_simd_prepare(c);
}

void paths_move(core *c)
{
    if (c->is_straight) {
        straight_move(c);
        return;
    }
    place_all(c);
    const int has_bends = USES_CABLE_FRICTION && c->blob.counts.bends;
    walk(c, has_bends);
    if (has_bends) bends_move(c);
}

void core_trace(core *c)
{
    walk(c, 1);
}
