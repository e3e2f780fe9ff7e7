/* Decision after the loss of muscles during a reference motion.

   A table contains, for each muscle and times of the reference, the speed of the reference relative to its own
   with which the other muscles can produce the motion from this time to its end; REACTION_POSE if they can only
   hold the poses of the next times, or REACTION_FALL if they cannot. If several muscles are lost, the smallest
   value applies.

   The decision never becomes less severe. If the forces of the remaining muscles do not suffice for some time,
   it becomes more severe. */
#ifndef CARDSFLOW_REACTION_H
#define CARDSFLOW_REACTION_H

#include "../qp/dual_newton.h" /* real, DUAL_NEWTON_API */

enum reaction_decision {
    REACTION_NONE = 0,
    REACTION_CONTINUE = 1, /* the motion is feasible */
    REACTION_SLOW = 2,     /* it is feasible at a smaller speed */
    REACTION_HOLD = 3,     /* the reference stops, and the pose is held */
    REACTION_STOP = 4,     /* the joints are braked, then the pose is held if possible */
};

#define REACTION_POSE 0
#define REACTION_FALL (-1)

typedef struct {
    size_t muscles, times;
    const real *begins; /* times, increasing, in [s] */
    const real *speeds; /* muscles x times */
    real patience;      /* time without sufficient forces until a more severe decision, in [s] */
    real *state;        /* reaction_state_length, to be saved and restored; see reaction.c */
} reaction;

DUAL_NEWTON_API size_t reaction_state_length(size_t muscles);

DUAL_NEWTON_API void reaction_reset(reaction *s);

/* Decide after losses: muscles whose bound is below their maximum force. Return an enum reaction_decision.

   path_time is the current time of the reference; bounds and f_max have one element per muscle, in [N]. */
DUAL_NEWTON_API int reaction_decide(reaction *s, real path_time, const real *bounds, const real *f_max);

/* Report whether the forces of a tick of h seconds were insufficient. */
DUAL_NEWTON_API void reaction_report(reaction *s, real h, int is_infeasible);

/* Return the speed of the reference relative to its own, from 0 to 1. */
DUAL_NEWTON_API real reaction_speed(const reaction *s);

/* Return the number of lost muscles. */
DUAL_NEWTON_API size_t reaction_lost(const reaction *s);

#endif
