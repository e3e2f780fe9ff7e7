/* Wraps over one surface each, many side by side. */
#ifndef CARDSFLOW_WRAP_SIMD_H
#define CARDSFLOW_WRAP_SIMD_H
#include "../blob/state.h"
#include "cable.h"

#define LANES 16

/* Of the wraps from `first` on, as many as there are lanes. */
typedef struct {
    int32_t first, count;
    real is_alone[LANES]; /* not 0: it takes wrap.c */
    real length[LANES], entering[3][LANES], leaving[3][LANES]; /* as of a pull, also of a straight cable */
} wrap_lanes;

/* Once, and when turns are to be counted or no longer. */
CORE_INSIDE void wrap_simd_prepare(core *c);
CORE_INSIDE void wrap_simd_fill(const core *c, int32_t first, wrap_lanes *out);

/* The directions that are asked for of a wrap alone in its segment: at ends that move against the surface. */
static inline int wrap_ends(const blob_view *blob, int32_t w)
{
    const int32_t frame = blob->surface_frame[blob->wrap_surface[w]];
    const int32_t *ends = blob->point_frame + blob->wrap_point[w];
    return (ends[0] != frame ? ENTERING : 0) | (ends[1] != frame ? LEAVING : 0);
}

#endif
