#include "check_parts.h"

#include "../../optional_parts.h"
#include "../message.h"

static int has_ellipsoids(const blob_view *b)
{
    for (int32_t k = 0; k < b->counts.surfaces; k++)
        if (b->surface_kind[k] == SURFACE_ELLIPSOID) return 1;
    return 0;
}

static int has_sequences(const blob_view *b)
{
    for (int32_t k = 1; k < b->counts.wraps; k++)
        if (b->wrap_point[k] == b->wrap_point[k - 1]) return 1;
    return b->counts.pulleys > 0;
}

static int has_routes(const blob_view *b)
{
    for (int32_t k = 0; k < b->counts.muscles; k++)
        if (b->muscle_points[k] < 2) return 1;
    for (int32_t k = 0; k < b->counts.wraps; k++)
        if (b->wrap_rule[k] != RULE_TAUT) return 1;
    return b->counts.conditions || b->counts.moves || b->counts.branches || b->counts.path_terms;
}

int check_parts(const blob_view *b, char *message, size_t capacity)
{
    const char *missing = !USES_WRAPS && b->counts.wraps                ? "WRAPS"
                          : !USES_ELLIPSOIDS && has_ellipsoids(b)       ? "ELLIPSOIDS"
                          : !USES_SEQUENCES && has_sequences(b)         ? "SEQUENCES"
                          : !USES_ROUTES && has_routes(b)               ? "ROUTES"
                          : !USES_CABLE_FRICTION && b->counts.bends > 0 ? "CABLE_FRICTION"
                                                                        : NULL;
    return missing ? reject(message, capacity, "the robot needs USES_%s; define it in CARDSFLOW_PARTS", missing) : 0;
}
