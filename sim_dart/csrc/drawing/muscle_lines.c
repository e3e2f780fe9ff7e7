/* Polylines along muscle paths, for drawing. */
#include "../core.h"

#include "../math/elementary.h"
#include "../math/vectors.h"
#include "../paths/ellipsoid/geodesic.h"
#include "../paths/place.h"

#include <math.h>
#include <string.h>

#define ARC_STEP 0.08726646259971647 /* 5 degrees */
#define GEODESIC_STEP 0.1 /* relative to the shortest half axis */
#define MAX_STEPS 1000
#define MAX_GEODESIC_STEPS 200
#define MAX_MISS 1e-3  /* of the end of a geodesic, relative to the shortest half axis */
#define MIN_SHARE 0.5 /* activity of a via point with which it is drawn */

typedef struct {
    real *points;
    int32_t capacity, count;
} polyline;

static void add_point(polyline *line, const real point[3])
{
    if (line->count < line->capacity) memcpy(line->points + 3 * (size_t)line->count, point, 3 * sizeof *point);
    line->count++;
}

static int are_equal(const real a[3], const real b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static int steps_of(real length, real step, int most)
{
    return length < most * step ? (int)ceil(length / step) : most;
}

/* Add the points between touch and lift of a contact that turns about its axis through `centre`. */
static void add_arc(polyline *line, const real *numbers, const real centre[3])
{
    const real *touch = numbers + 12, *lift = numbers + 15, *n = numbers + 18, angle = numbers[CONTACT_NUMBERS - 1];
    const int steps = steps_of(angle, ARC_STEP, MAX_STEPS);
    real start[3], across[3], aside[3], chord[3], point[3];
    for (int i = 0; i < 3; i++) start[i] = touch[i] - centre[i], chord[i] = lift[i] - touch[i];
    const real along = dot3(start, n), climb = dot3(chord, n);
    for (int i = 0; i < 3; i++) across[i] = start[i] - along * n[i];
    cross3(aside, n, across);
    for (int k = 1; k < steps; k++) {
        const real share = (real)k / steps, c = cosine(angle * share), s = sine(angle * share);
        for (int i = 0; i < 3; i++)
            point[i] = centre[i] + c * across[i] + s * aside[i] + (along + climb * share) * n[i];
        add_point(line, point);
    }
}

/* Add the points between touch and lift along a geodesic; if it misses the lift, along the projection of the
   chord from the centre. Lengths are relative to the shortest half axis. */
static void add_geodesic(polyline *line, const real *numbers, const wrap_surface *s)
{
    real axes[3][3], half[3] = {s->radius, s->half_axes[0], s->half_axes[1]}, least = half[0];
    real begin[3], end[3], size = 0, miss = 0;
    geodesic_point p = {.j = 0, .dj = 1}, last;
    for (int i = 1; i < 3; i++)
        if (half[i] < least) least = half[i];
    const real way = numbers[CONTACT_NUMBERS - 1] / least;
    const int steps = steps_of(way, GEODESIC_STEP, MAX_GEODESIC_STEPS);
    memcpy(axes[0], s->across, sizeof axes[0]), memcpy(axes[2], s->axis, sizeof axes[2]);
    cross3(axes[1], s->axis, s->across);
    for (int i = 0; i < 3; i++) {
        begin[i] = (dot3(axes[i], numbers + 12) - dot3(axes[i], s->centre)) / least;
        end[i] = (dot3(axes[i], numbers + 15) - dot3(axes[i], s->centre)) / least;
        p.x[i] = begin[i], p.v[i] = dot3(axes[i], numbers + 3), half[i] /= least;
        size += begin[i] * begin[i] / (half[i] * half[i]);
    }
    for (int i = 0; i < 3; i++) half[i] *= sqrt(size); /* a point inside shrinks the ellipsoid */
    last = p;
    geodesic_follow(half, way, FINE_TERM, &last, NULL, NULL);
    for (int i = 0; i < 3; i++) miss += (last.x[i] - end[i]) * (last.x[i] - end[i]);
    for (int k = 1; k < steps; k++) {
        real point[3], scale = 1;
        if (sqrt(miss) <= MAX_MISS)
            geodesic_follow(half, way / steps, FINE_TERM, &p, NULL, NULL);
        else {
            size = 0;
            for (int i = 0; i < 3; i++) {
                p.x[i] = begin[i] + (end[i] - begin[i]) * k / steps;
                size += p.x[i] * p.x[i] / (half[i] * half[i]);
            }
            scale = 1 / sqrt(size);
        }
        for (int i = 0; i < 3; i++)
            point[i] = s->centre[i] +
                       least * scale * (p.x[0] * axes[0][i] + p.x[1] * axes[1][i] + p.x[2] * axes[2][i]);
        add_point(line, point);
    }
}

static void add_contact(polyline *line, const real *numbers, const wrap_surface *s, const real centre[3])
{
    const real *touch = numbers + 12, *lift = numbers + 15;
    if (numbers[CONTACT_NUMBERS - 1] == 0) return;
    add_point(line, touch);
    if (are_equal(touch, lift)) return;
    if (s && s->kind == SURFACE_ELLIPSOID)
        add_geodesic(line, numbers, s);
    else
        add_arc(line, numbers, centre);
    add_point(line, lift);
}

/* The centre of a pulley is perpendicular to the incoming cable. */
static void add_pulley(const core *c, int32_t p, polyline *line)
{
    const real *numbers = c->pulley_contact + CONTACT_NUMBERS * p, *touch = numbers + 12, *lift = numbers + 15;
    real radius = c->blob.pulley_radius[p], across[3], chord[3], centre[3];
    cross3(across, numbers + 18, numbers + 3);
    for (int i = 0; i < 3; i++) chord[i] = lift[i] - touch[i];
    if (are_equal(lift, numbers + 6)) /* the cable ends inside of it */
        radius = sqrt(dot3(chord, chord)) / (2 * sine(numbers[CONTACT_NUMBERS - 1] / 2));
    for (int i = 0; i < 3; i++) centre[i] = touch[i] + radius * across[i];
    add_contact(line, numbers, NULL, centre);
}

/* Return the wrap after `last` among those after a via point, or -1. */
static int32_t next_wrap(const core *c, int32_t point, int32_t last)
{
    int32_t next = -1;
    for (int32_t w = 0; w < c->blob.counts.wraps; w++) {
        const real *rank = c->wrap_rank;
        const int is_later = last < 0 || rank[w] > rank[last] || (rank[w] == rank[last] && w > last);
        if (c->wrap_before[w] == point && is_later && (next < 0 || rank[w] < rank[next])) next = w;
    }
    return next;
}

int32_t core_lines(core *c, int32_t *sizes, real *points, int32_t capacity)
{
    polyline line = {points, capacity, 0};
    core_trace(c);
    for (int32_t m = 0, k = 0, p = 0; m < c->blob.counts.muscles; m++) {
        const int32_t before = line.count, end = k + c->blob.muscle_points[m];
        for (; k < end; k++) {
            if (c->point_share[k] >= MIN_SHARE) add_point(&line, c->point + 3 * k);
            if (p < c->blob.counts.pulleys && c->blob.pulley_point[p] == k) add_pulley(c, p++, &line);
            if (c->point_share[k] < MIN_SHARE) continue;
            for (int32_t w = next_wrap(c, k, -1); w >= 0; w = next_wrap(c, k, w)) {
                const wrap_surface s = wrapped_surface(c, w);
                add_contact(&line, c->wrap_contact + CONTACT_NUMBERS * w, &s, s.centre);
            }
        }
        sizes[m] = line.count - before;
    }
    return line.count;
}
