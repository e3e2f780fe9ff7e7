#include "check_paths.h"

#include "../../math/elementary.h"
#include "../../math/vectors.h"
#include "../../numbers/real_functions.h"
#include "check_points.h"
#include "check_routes.h"
#include "../../optional_parts.h"
#include "../message.h"

#include <math.h>

#define MAX_TURNS 1000000

static int is_unit(const real a[3])
{
    return fabs(dot3(a, a) - 1) < UNIT_TOLERANCE;
}

static int is_size(real value)
{
    return value > 0 && isfinite(value);
}

static int check_surfaces(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.surfaces; k++) {
        if (b->surface_kind[k] < 0 || b->surface_kind[k] >= SURFACES)
            return reject(message, capacity, "surface %d: unknown kind %d", k, (int)b->surface_kind[k]);
        if (!is_unit(b->surface_axis + 3 * k))
            return reject(message, capacity, "surface %d: its axis is not a unit vector", k);
        if (!is_size(b->surface_radius[k]) || (b->surface_half[k] != 0 && !is_size(b->surface_half[k])))
            return reject(message, capacity, "surface %d: its size must be positive and finite", k);
        if (b->surface_half[k] != 0 && b->surface_kind[k] != SURFACE_CYLINDER)
            return reject(message, capacity, "surface %d: only a cylinder has ends", k);
    }
    return 0;
}

static int check_ellipsoids(const blob_view *b, char *message, size_t capacity)
{
    for (int k = 0; k < b->counts.surfaces; k++) {
        const real *axes = b->surface_half_axes + 2 * k, radius = b->surface_radius[k];
        const real *across = b->surface_across + 3 * k;
        if (b->surface_kind[k] != SURFACE_ELLIPSOID) {
            if (axes[0] != 0 || axes[1] != 0)
                return reject(message, capacity, "surface %d: only an ellipsoid has half axes", k);
            continue;
        }
        if (!is_unit(across) || !(fabs(dot3(across, b->surface_axis + 3 * k)) < UNIT_TOLERANCE))
            return reject(message, capacity, "surface %d: its x axis must be a unit vector normal to z", k);
        if (!is_size(axes[0]) || !is_size(axes[1]))
            return reject(message, capacity, "surface %d: its half axes must be positive and finite", k);
        const real longest = larger(larger(axes[0], axes[1]), radius), least = smaller(smaller(axes[0], axes[1]), radius);
        if (longest > MAX_HALF_AXIS * least * (1 + UNIT_TOLERANCE))
            return reject(message, capacity, "surface %d: its ratio of half axes is more than %d", k,
                          MAX_HALF_AXIS);
    }
    return 0;
}

static int check_ellipsoid_wrap(const blob_view *b, int k, char *message, size_t capacity)
{
    if (b->surface_kind[b->wrap_surface[k]] == SURFACE_ELLIPSOID &&
        (b->wrap_side[k] || b->wrap_turns[k] || b->wrap_rule[k] == RULE_MUJOCO))
        return reject(message, capacity, "wrap %d: an ellipsoid has no side, turns or MuJoCo rule", k);
    return 0;
}

static int check_wraps(const blob_view *b, char *message, size_t capacity)
{
    int32_t of_segment = 0, muscle = 0, end = b->counts.muscles ? b->muscle_points[0] : 0, opensim_wraps = 0;
    for (int k = 0; k < b->counts.wraps; k++) {
        const int32_t point = b->wrap_point[k];
        if (point < 0 || point >= b->counts.points - 1)
            return reject(message, capacity, "wrap %d: no segment begins at via point %d", k, (int)point);
        if (k && point < b->wrap_point[k - 1])
            return reject(message, capacity, "wrap %d is out of order", k);
        while (end <= point) end += b->muscle_points[++muscle], opensim_wraps = 0;
        if (point == end - 1)
            return reject(message, capacity, "wrap %d: via point %d is the muscle's last", k, (int)point);
        if (b->wrap_rule[k] < 0 || b->wrap_rule[k] >= RULES)
            return reject(message, capacity, "wrap %d: unknown rule %d", k, (int)b->wrap_rule[k]);
        if (b->wrap_last[k] < point || b->wrap_last[k] >= end - 1 ||
            (b->wrap_last[k] != point && b->wrap_rule[k] != RULE_OPENSIM))
            return reject(message, capacity, "wrap %d: it cannot end at via point %d", k, (int)b->wrap_last[k]);
        opensim_wraps += b->wrap_rule[k] == RULE_OPENSIM;
        if (opensim_wraps > MAX_SEQUENCE)
            return reject(message, capacity, "wrap %d: more than %d OpenSim wraps in one muscle", k, MAX_SEQUENCE);
        if (b->wrap_guide[k] < -1 || b->wrap_guide[k] >= b->counts.guides)
            return reject(message, capacity, "wrap %d: unknown guide %d", k, (int)b->wrap_guide[k]);
        of_segment = k && point == b->wrap_point[k - 1] ? of_segment + 1 : 1;
        if (of_segment > MAX_SEQUENCE)
            return reject(message, capacity, "wrap %d: more than %d in one segment", k, MAX_SEQUENCE);
        if (b->wrap_surface[k] < 0 || b->wrap_surface[k] >= b->counts.surfaces)
            return reject(message, capacity, "wrap %d: unknown surface %d", k, (int)b->wrap_surface[k]);
        if (b->wrap_side[k] < -1 || b->wrap_side[k] > WRAP_INSIDE)
            return reject(message, capacity, "wrap %d: unknown side %d", k, (int)b->wrap_side[k]);
        if (b->wrap_turns[k] < 0 || b->wrap_turns[k] > MAX_TURNS)
            return reject(message, capacity, "wrap %d: turns %d must be from 0 to %d", k,
                          (int)b->wrap_turns[k], MAX_TURNS);
        if (b->wrap_rule[k] != RULE_TAUT && (b->wrap_side[k] || b->wrap_turns[k]))
            return reject(message, capacity, "wrap %d: its rule has no side or turns", k);
        if (b->wrap_side[k] == WRAP_INSIDE && b->wrap_turns[k])
            return reject(message, capacity, "wrap %d: no turns inside a surface", k);
        if (check_ellipsoid_wrap(b, k, message, capacity)) return 1;
    }
    return 0;
}

static int check_pulleys(const blob_view *b, char *message, size_t capacity)
{
    int32_t first = 0, muscle = 0;
    for (int k = 0; k < b->counts.pulleys; k++) {
        if (k && b->pulley_point[k] <= b->pulley_point[k - 1])
            return reject(message, capacity, "pulley %d is out of order", k);
        while (muscle < b->counts.muscles && first < b->pulley_point[k])
            first += b->muscle_points[muscle++];
        if (first != b->pulley_point[k] || first >= b->counts.points)
            return reject(message, capacity, "pulley %d: no muscle begins at via point %d", k,
                          (int)b->pulley_point[k]);
        if (!is_unit(b->pulley_direction + 3 * k))
            return reject(message, capacity, "pulley %d: its direction is not a unit vector", k);
        if (!is_size(b->pulley_radius[k]))
            return reject(message, capacity, "pulley %d: its radius must be positive and finite", k);
    }
    return 0;
}

int check_paths(const blob_view *b, char *message, size_t capacity)
{
    return check_points("surface", b->surface_frame, b->surface_centre, b->counts.surfaces, b->counts.frames,
                        message, capacity) ||
           check_surfaces(b, message, capacity) || (USES_ELLIPSOIDS && check_ellipsoids(b, message, capacity)) ||
           (USES_WRAPS && check_wraps(b, message, capacity)) || (USES_SEQUENCES && check_pulleys(b, message, capacity)) ||
           (USES_ROUTES && check_routes(b, message, capacity));
}
