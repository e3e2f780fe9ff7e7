/* Current poses of the surfaces and wraps of a blob, and the record of a contact. */
#ifndef CARDSFLOW_PLACE_H
#define CARDSFLOW_PLACE_H

#include "../blob/state.h"
#include "../optional_parts.h"
#include "cable.h"

#include <string.h>

static inline void write_contact(real *at, const contact *k, const real begin[3], const real end[3])
{
    const real *vectors[] = {begin, k->pull.entering, end, k->pull.leaving, k->touch, k->lift, k->axis};
    for (size_t j = 0; j < sizeof vectors / sizeof *vectors; j++)
        memcpy(at + 3 * j, vectors[j], 3 * sizeof(real));
    at[CONTACT_NUMBERS - 1] = k->pull.angle;
}

static inline wrap_surface placed_surface(const core *c, int32_t s)
{
    const real *place = c->surface_place + 6 * s;
    const wrap_surface placed = {c->blob.surface_kind[s], c->blob.surface_radius[s],
                                 c->blob.surface_half[s], place, place + 3,
                                 c->surface_across + 3 * s, c->blob.surface_half_axes + 2 * s, NULL};
    return placed;
}

/* Return the surface of a wrap. */
static inline wrap_surface wrapped_surface(const core *c, int32_t w)
{
    wrap_surface placed = placed_surface(c, c->blob.wrap_surface[w]);
    if (USES_ELLIPSOIDS) placed.stored = c->stored_path + PATH_NUMBERS * w;
    return placed;
}

static inline wrap_way wrap_way_of(const core *c, int32_t w)
{
    const wrap_way way = {
        .side = c->blob.wrap_side[w],
        .turns = c->blob.wrap_turns[w],
    };
    return way;
}

/* Return the first frame from `frame` towards the world that the only moving coordinate moves; -1 if none. */
static inline int32_t moving_frame(const core *c, int32_t frame)
{
    while (frame >= 0 && c->blob.coordinate[frame] != c->moving - 1) frame = c->blob.parent[frame];
    return frame;
}

/* Return whether q has a tangent along one coordinate, which moves the points i and j and the surfaces between
   them, from wrap w on, like one body: l and L of this part of a path then have no tangent. */
static inline int is_rigid(const core *c, int32_t i, int32_t j, int32_t w)
{
    if (!HAS_TANGENT || !c->moving || c->is_driven) return 0;
    const int32_t frame = moving_frame(c, c->blob.point_frame[i]);
    for (; w < c->blob.counts.wraps && c->blob.wrap_point[w] < j; w++) {
        const int32_t surface = c->blob.surface_frame[c->blob.wrap_surface[w]];
        if (index_of(c->wrap_before[w]) == i && moving_frame(c, surface) != frame) return 0;
    }
    return moving_frame(c, c->blob.point_frame[j]) == frame;
}

#endif
