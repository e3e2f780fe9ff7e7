/* Wraps with the rules of other programs: their segments, and the path over them.

   OpenSim processes one wrap after the other, each on the path over the others. Of the segments in its
   range, and of the straight parts between other wraps, the wrap is on the first one that meets its surface,
   otherwise on the one whose length increases least. This repeats until nothing changes. The path over all
   wraps is then the taut one; OpenSim itself uses an approximation. */
#include "route_wraps.h"

#include "../../kinematics/tree.h"
#include "../../math/elementary.h"
#include "../multi_wrap.h"
#include "../place.h"
#include "../span.h"
#include "../wrap.h"
#include "wrap_rules.h"

#include <math.h>
#include <string.h>

#define ROUNDS 8

static wrap_surface surface_of(const core *c, int32_t w)
{
    return wrapped_surface(c, w);
}

/* The rules of other programs do not taper the ends of a cylinder. */
static wrap_surface without_ends(wrap_surface s)
{
    s.half = 0;
    return s;
}

int route_wraps_rule(const core *c, int32_t w, const real A[3], const real B[3], wrap_surface *s, wrap_way *way)
{
    const int32_t g = c->blob.wrap_guide[w];
    real guide[3];
    memset(way, 0, sizeof *way);
    if (g >= 0 && c->blob.wrap_rule[w] == RULE_MUJOCO)
        tree_point(c, c->blob.guide_frame[g], c->blob.guide_vector + 3 * g, guide);
    else if (g >= 0)
        tree_direction(c, c->blob.guide_frame[g], c->blob.guide_vector + 3 * g, guide);
    const int how = wrap_rule(c->blob.wrap_rule[w], s, g >= 0 ? guide : NULL, A, B, way);
    *s = without_ends(*s);
    return how;
}

static const real *point_of(const core *c, int32_t k)
{
    return c->point + 3 * k;
}

static int32_t in_use_from(const core *c, int32_t k, int32_t end)
{
    while (k < end && c->point_share[k] == 0) k++;
    return k;
}

/* ------------------------------------------------------------------------------ segments of the path */

/* Best segment found for a wrap. */
typedef struct {
    int32_t before;
    int rank, sense;
    real change, touch[3], lift[3];
} place_found;

static real *touch_of(const core *c, int32_t w)
{
    return c->wrap_contact + CONTACT_NUMBERS * w + 12;
}

/* Return the wrap of a rank between point i and the next, skipping one; -1 if it does not exist. */
static int32_t wrap_of_rank(const core *c, const route *r, int32_t i, int rank, int32_t except)
{
    for (int32_t w = r->wraps; w < r->wraps + r->wrap_count; w++)
        if (w != except && (int32_t)value_of(c->wrap_before[w]) == i && (int)value_of(c->wrap_rank[w]) == rank) return w;
    return -1;
}

/* Evaluate a straight part. Return 1 if its line meets the surface. */
static int try_part(const core *c, int32_t w, int32_t i, int rank, const real A[3], const real B[3], place_found *best)
{
    wrap_way way;
    contact over;
    wrap_surface s = surface_of(c, w);
    const int how = route_wraps_rule(c, w, A, B, &s, &way);
    if (how == RULE_STRAIGHT) return 0;
    wrap_over(&s, &way, A, B, &over);
    const real d[3] = {B[0] - A[0], B[1] - A[1], B[2] - A[2]}, change = over.pull.length - sqrt(dot3(d, d));
    if (how != RULE_MEETS && !(value_of(change) < value_of(best->change))) return 0;
    best->before = i, best->rank = rank, best->sense = way.side, best->change = change;
    memcpy(best->touch, over.touch, sizeof over.touch);
    memcpy(best->lift, over.lift, sizeof over.lift);
    return how == RULE_MEETS;
}

static place_found find_place(const core *c, const route *r, int32_t w)
{
    const int32_t stop = c->blob.wrap_last[w] + 2;
    place_found best = {.before = -1, .change = INFINITY};
    for (int32_t i = in_use_from(c, c->blob.wrap_point[w], stop), j; i < stop; i = j) {
        j = in_use_from(c, i + 1, stop);
        if (j >= stop) break;
        const real *from = point_of(c, i);
        for (int rank = 0; from; rank++) {
            const int32_t other = wrap_of_rank(c, r, i, rank, w);
            if (try_part(c, w, i, rank, from, other < 0 ? point_of(c, j) : touch_of(c, other), &best)) return best;
            from = other < 0 ? NULL : touch_of(c, other) + 3;
        }
    }
    return best;
}

/* Remove a wrap from the path, or insert it, and shift the ranks after it. */
static void shift_ranks(core *c, const route *r, int32_t i, int rank, int by)
{
    for (int32_t w = r->wraps; w < r->wraps + r->wrap_count; w++)
        if ((int32_t)value_of(c->wrap_before[w]) == i && (int)value_of(c->wrap_rank[w]) >= rank) c->wrap_rank[w] += by;
}

/* Place a wrap again. Return whether its segment has changed. */
static int relocate_wrap(core *c, const route *r, int32_t w)
{
    const int32_t was = (int32_t)value_of(c->wrap_before[w]);
    const int rank = (int)value_of(c->wrap_rank[w]), sense = (int)value_of(c->wrap_turn[w]);
    c->wrap_before[w] = -1;
    if (was >= 0) shift_ranks(c, r, was, rank, -1);
    const place_found found = find_place(c, r, w);
    if (found.before >= 0) shift_ranks(c, r, found.before, found.rank, 1);
    c->wrap_before[w] = found.before, c->wrap_rank[w] = found.rank, c->wrap_turn[w] = found.sense;
    memcpy(touch_of(c, w), found.touch, sizeof found.touch);
    memcpy(touch_of(c, w) + 3, found.lift, sizeof found.lift);
    return found.before != was || (was >= 0 && (found.rank != rank || found.sense != sense));
}

void route_wraps_choose(core *c, const route *r)
{
    int is_searched = 0;
    for (int32_t w = r->wraps, rank = 0; w < r->wraps + r->wrap_count; w++) {
        if (c->blob.wrap_rule[w] == RULE_OPENSIM) {
            c->wrap_before[w] = -1, is_searched++;
            continue;
        }
        int32_t i = c->blob.wrap_point[w];
        while (i >= r->first && c->point_share[i] == 0) i--;
        rank = w > r->wraps && (int32_t)value_of(c->wrap_before[w - 1]) == i ? rank + 1 : 0;
        c->wrap_before[w] = i < r->first ? -1 : i, c->wrap_rank[w] = rank, c->wrap_turn[w] = 0;
    }
    for (int round = 0, is_changed = 1; round < (is_searched > 1 ? ROUNDS : is_searched) && is_changed; round++) {
        is_changed = 0;
        for (int32_t w = r->wraps; w < r->wraps + r->wrap_count; w++)
            if (c->blob.wrap_rule[w] == RULE_OPENSIM) is_changed |= relocate_wrap(c, r, w);
    }
}

/* ------------------------------------------------------------------------------ path over the wraps */

static void take(const core *c, const route *r, const real u[3], const real at[3], int32_t a, int32_t b, real *row)
{
    const real scaled[3] = {r->factor * u[0], r->factor * u[1], r->factor * u[2]};
    span_add(c, scaled, at, a, at, b, row);
}

/* Compute the path over one surface. */
static int path_over_one(core *c, const route *r, int32_t w, int32_t i, int32_t j, path_between *way, real *row,
                         int is_traced)
{
    const real *A = point_of(c, i), *B = point_of(c, j);
    const int32_t frame = c->blob.surface_frame[c->blob.wrap_surface[w]], rule = c->blob.wrap_rule[w];
    wrap_surface s = surface_of(c, w);
    wrap_way round = wrap_way_of(c, w);
    pull over;
    if (rule == RULE_OPENSIM) { /* applied when the segment was selected */
        const wrap_way selected = {.side = (int32_t)value_of(c->wrap_turn[w]), .is_forced = 1};
        s = without_ends(s), round = selected;
    } else if (rule != RULE_TAUT && route_wraps_rule(c, w, A, B, &s, &round) == RULE_STRAIGHT)
        return 0;
    if (is_traced) {
        contact passed;
        wrap_over(&s, &round, A, B, &passed);
        write_contact(c->wrap_contact + CONTACT_NUMBERS * w, &passed, A, B);
    }
    if (!wrap_pull(&s, &round, A, B, BOTH_ENDS, &over)) return 0;
    way->length = over.length;
    memcpy(way->entering, over.entering, sizeof over.entering);
    memcpy(way->leaving, over.leaving, sizeof over.leaving);
    take(c, r, over.entering, A, c->blob.point_frame[i], frame, row);
    take(c, r, over.leaving, B, frame, c->blob.point_frame[j], row);
    return 1;
}

/* Compute the path over several surfaces. If all wraps have our own rules, the cable may be the straight
   line between the points. */
static int path_over_several(core *c, const route *r, const int32_t *wraps, int count, int32_t i, int32_t j,
                             path_between *way, real *row, int is_traced)
{
    sequence_part parts[MAX_SEQUENCE];
    wrap_surface placed[MAX_SEQUENCE];
    contact contacts[MAX_SEQUENCE + 1];
    real points[MAX_SEQUENCE + 2][3];
    int is_free = 1;
    memset(parts, 0, sizeof parts);
    memset(contacts, 0, sizeof contacts);
    memcpy(points[0], point_of(c, i), sizeof points[0]);
    memcpy(points[count], point_of(c, j), sizeof points[count]);
    for (int k = 0; k < count; k++) {
        const int32_t w = wraps[k];
        const int is_taut = c->blob.wrap_rule[w] == RULE_TAUT;
        parts[k].way = wrap_way_of(c, w);
        placed[k] = is_taut ? surface_of(c, w) : without_ends(surface_of(c, w));
        parts[k].surface = placed + k;
        if (!is_taut) parts[k].way.side = (int32_t)value_of(c->wrap_turn[w]), parts[k].way.is_forced = 1;
        is_free = is_free && is_taut && !parts[k].way.turns &&
                  wrap_is_clear(parts[k].surface, &parts[k].way, points[0], points[count]);
    }
    if (is_free) return 0;
    way->length = sequence_solve(parts, count, points, contacts);
    for (int k = 0; k <= count; k++) {
        const real *u = k < count ? contacts[k].pull.entering : contacts[k - 1].pull.leaving;
        const int32_t before = k ? c->blob.surface_frame[c->blob.wrap_surface[wraps[k - 1]]] : c->blob.point_frame[i];
        const int32_t after = k < count ? c->blob.surface_frame[c->blob.wrap_surface[wraps[k]]] : c->blob.point_frame[j];
        take(c, r, u, points[k], before, after, row);
        memcpy(k ? way->leaving : way->entering, u, sizeof way->entering);
        if (k == count) break;
        if (is_traced) write_contact(c->wrap_contact + CONTACT_NUMBERS * wraps[k], contacts + k, points[k], points[k + 1]);
    }
    return 1;
}

int route_wraps_over(core *c, const route *r, int32_t i, int32_t j, path_between *way, real *row, int is_traced)
{
    int32_t wraps[MAX_SEQUENCE];
    int count = 0;
    for (int32_t w = r->wraps; w < r->wraps + r->wrap_count && is_traced; w++)
        if ((int32_t)value_of(c->wrap_before[w]) == i) c->wrap_contact[CONTACT_NUMBERS * w + CONTACT_NUMBERS - 1] = 0;
    for (; count < MAX_SEQUENCE; count++)
        if ((wraps[count] = wrap_of_rank(c, r, i, count, -1)) < 0) break;
    if (!count) return 0;
    return count == 1 ? path_over_one(c, r, wraps[0], i, j, way, row, is_traced)
                      : path_over_several(c, r, wraps, count, i, j, way, row, is_traced);
}
