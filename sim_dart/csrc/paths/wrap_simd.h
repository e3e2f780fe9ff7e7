/* Wraps over one surface each, computed in parallel. */
#ifndef CARDSFLOW_WRAP_SIMD_H
#define CARDSFLOW_WRAP_SIMD_H
#include "../blob/state.h"
#include "cable.h"

#define LANES 16

/* Whether vectors of four numbers can be chosen when a robot is opened. */
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__OPTIMIZE_SIZE__) &&                  \
    !defined(CARDSFLOW_TANGENT) && !defined(CARDSFLOW_FLOAT)
#define HAS_WIDE_LANES 1
#define IN_LANES static inline __attribute__((always_inline))
#else
#define HAS_WIDE_LANES 0
#define IN_LANES static inline
#endif

/* Results of the wraps of the lanes from `first` on. */
typedef struct {
    int32_t first, count, padded;
    real is_alone[LANES]; /* nonzero: wrap.c must compute it */
    real length[LANES], entering[3][LANES], leaving[3][LANES]; /* as in a pull, also of a straight cable */
} wrap_lanes;

/* Call this once, and when counting of turns is enabled or disabled. */
CORE_INSIDE void wrap_simd_prepare(core *c);
CORE_INSIDE void wrap_simd_fill(const core *c, int32_t first, wrap_lanes *out);

/* Return the needed directions of the only wrap in a segment: at ends that move relative to the surface. */
static inline int wrap_ends(const blob_view *blob, int32_t w)
{
    const int32_t frame = blob->surface_frame[blob->wrap_surface[w]];
    const int32_t *ends = blob->point_frame + blob->wrap_point[w];
    return (ends[0] != frame ? ENTERING : 0) | (ends[1] != frame ? LEAVING : 0);
}

#endif
