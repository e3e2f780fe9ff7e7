/* The search starts at the shortest plane paths (fan.c), at each local minimum among neighbouring planes. The
   shortest solution is selected: it depends only on the ends, not on earlier moves. */
#include "taut_search.h"

#include "../../math/elementary.h"
#include "../../math/vectors.h"
#include "shot.h"

#include <math.h>
#include <string.h>

#define MAX_SHOTS 40
#define CONTINUED_SHOTS 8 /* the same from a contact with other ends; if these fail, the search starts again */
#define HALVINGS 6
#define LAST_SHOT_STEP PRECISE(1e-8, 2e-4) /* last step: the remaining error is about its square */
#define ROUNDING_SQUARE PRECISE(1e-24, 1e-10)      /* square of the residual that only rounding errors cause */
#define MAX_TURN 0.5
#define FINE_FROM 1e-3 /* after smaller steps, geodesics are computed up to rounding */
#define ROUGH_TERM PRECISE(1e-9, 1e-7)

/* Iterate, at most that many shots. Each step is shortened until the residual decreases. Return whether it converges. */
static int solve_geodesic(const cable_ends *e, int most, shot *s)
{
    real last_term = ROUGH_TERM;
    shot_follow(e, last_term, s);
    for (int shots = 1; shots < most;) {
        real step[3] = {0, 0, 0};
        const real size = shot_step(s, step);
        if (!isfinite(size)) return 0;
        const int is_last = last_term == FINE_TERM && (size <= LAST_SHOT_STEP || s->square <= ROUNDING_SQUARE);
        if (size <= FINE_FROM) last_term = FINE_TERM;
        real part = size > MAX_TURN ? MAX_TURN / size : 1;
        shot next = *s;
        for (int halving = 0;; halving++, part *= 0.5) {
            next.way = s->way;
            shot_move(&next.way, step, part);
            if (is_last) { /* only the end tangents are needed */
                shot_tangents(e, &next);
                *s = next;
                return 1;
            }
            shot_follow(e, last_term, &next), shots++;
            if (halving == HALVINGS || next.square < s->square) break;
        }
        *s = next;
    }
    return 0;
}

/* Return whether the contact begins or ends in a half. */
static int is_on_side(const shot *s, int side)
{
    const int k = (side < 0 ? -side : side) - 1, sign = side < 0 ? -1 : 1;
    return !side || sign * s->a.x[k] >= 0 || sign * s->b.x[k] >= 0;
}

/* Find the shortest solution from starts in a number of planes. Return 0 if a start does not converge. */
static int search_planes(const cable_ends *e, int planes, int side, shot *best, int *is_found)
{
    path_over starts[MAX_STARTS];
    const int count = fan_starts(e->r, e->cones, planes, starts);
    int is_complete = count > 0;
    for (int k = 0; k < count; k++) {
        shot s;
        s.way = starts[k];
        if (!solve_geodesic(e, MAX_SHOTS, &s) || !(s.way.contact > 0)) {
            is_complete = 0;
            continue;
        }
        const int rank = is_on_side(&s, side) ? 2 : 1; /* contacts in the half have priority */
        if (rank < *is_found) continue;
        if (rank > *is_found || shot_length(&s) < shot_length(best)) *best = s;
        *is_found = rank;
    }
    return is_complete;
}

static void set_ends(const taut_task *task, cable_ends *e)
{
    memcpy(e->r, task->r, sizeof e->r);
    memcpy(e->a, task->ends[0], sizeof e->a);
    memcpy(e->b, task->ends[1], sizeof e->b);
    fan_cones(task->scaled[0], task->scaled[1], e->cones);
}

static path_over path_of(const real way[WAY_NUMBERS])
{
    const path_over path = {{way[0], way[1]}, {way[2], way[3]}, way[4]};
    return path;
}

static void write_way(const path_over *path, real way[WAY_NUMBERS])
{
    memcpy(way, path->a, sizeof path->a);
    memcpy(way + 2, path->b, sizeof path->b);
    way[4] = path->contact;
}

enum taut_answer taut_search(const taut_task *task, real way[WAY_NUMBERS])
{
    cable_ends e;
    shot best;
    path_over starts[MAX_STARTS];
    int is_found = 0;
    set_ends(task, &e);
    best.way = path_of(task->from);
    if (task->is_continued && solve_geodesic(&e, CONTINUED_SHOTS, &best) && best.way.contact > 0) {
        write_way(&best.way, way);
        return TAUT_PATH;
    }
    if (!search_planes(&e, FEW_PLANES, task->side, &best, &is_found))
        search_planes(&e, MANY_PLANES, task->side, &best, &is_found);
    if (is_found) {
        write_way(&best.way, way);
        return TAUT_PATH;
    }
    /* the few cases across a long ellipsoid in which shooting fails: the path in the best plane is longer */
    if (!fan_starts(e.r, e.cones, MANY_PLANES, starts)) return TAUT_NONE;
    write_way(starts, way);
    return TAUT_PLANE;
}

void taut_fields(const taut_task *task, const real way[WAY_NUMBERS], real fields[4])
{
    cable_ends e;
    shot s;
    set_ends(task, &e);
    s.way = path_of(way);
    shot_tangents(&e, &s);
    geodesic_point p = {.j = 1, .dj = 0};
    fields[2] = 0, fields[3] = 1;
    memcpy(p.x, s.a.x, sizeof p.x);
    memcpy(p.v, s.a.t, sizeof p.v);
    geodesic_follow(e.r, s.way.contact, FINE_TERM, &p, fields + 2, NULL);
    fields[0] = p.j, fields[1] = p.dj;
}
