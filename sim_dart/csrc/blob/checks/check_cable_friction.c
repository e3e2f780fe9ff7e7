#include "check_cable_friction.h"

#include "../../cable_friction/bends.h"
#include "../../optional_parts.h"
#include "../message.h"

#define MAX_FRICTION 2
#define MAX_PRESLIDING 1

static int is_any_in(int32_t first, int32_t end, const int32_t *points, int32_t count)
{
    for (int32_t k = 0; k < count; k++)
        if (points[k] >= first && points[k] < end) return 1;
    return 0;
}

/* Return whether the path consists of fixed points and taut wraps only. Other paths do not have a fixed
   order of spans, which cable friction needs. */
static int is_simple(const blob_view *b, int32_t muscle, int32_t first)
{
    const int32_t end = first + b->muscle_points[muscle];
    if (end - first < 2) return 0;
    for (int k = 0; k < b->counts.wraps; k++)
        if (b->wrap_point[k] >= first && b->wrap_point[k] < end && b->wrap_rule[k] != RULE_TAUT) return 0;
    if (is_any_in(first, end, b->condition_point, b->counts.conditions)) return 0;
    if (is_any_in(first, end, b->move_point, b->counts.moves)) return 0;
    if (is_any_in(first, end, b->branch_point, b->counts.branches)) return 0;
    return !is_any_in(muscle, muscle + 1, b->path_term_muscle, b->counts.path_terms);
}

int check_cable_friction(const blob_view *view, char *message, size_t capacity)
{
    if (!USES_CABLE_FRICTION) return 0;
    int32_t wrap = 0, pulley = 0;
    int64_t left = view->counts.bends;
    const real *mu = view->bend_friction;
    for (int32_t m = 0, first = 0; m < view->counts.muscles; first += view->muscle_points[m++]) {
        const int32_t bends = view->muscle_bends[m], points = view->muscle_points[m];
        const int32_t contacts = contacts_before(view, first + points, &wrap, &pulley);
        const real way = view->presliding[m];
        if (!(way > 0 && way <= MAX_PRESLIDING))
            return reject(message, capacity, "muscle %d: its presliding must be above 0 and up to %d m", (int)m, MAX_PRESLIDING);
        if (bends && !is_simple(view, m, first))
            return reject(message, capacity, "muscle %d: its path cannot have friction", (int)m);
        if (bends && bends != points - 2 + contacts)
            return reject(message, capacity, "muscle %d: its cable does not have %d bends", (int)m, (int)bends);
        left -= bends;
        for (int32_t k = 0; k < bends && left >= 0; k++, mu++)
            if (!(*mu >= 0 && *mu <= MAX_FRICTION))
                return reject(message, capacity, "muscle %d: its friction must be from 0 to %d", (int)m, MAX_FRICTION);
    }
    return left ? reject(message, capacity, "the bends of muscles do not add up") : 0;
}
