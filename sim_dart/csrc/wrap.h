/* The ways of a cable that are not straight: over a surface, over several, off a pulley.

   Each is a length l(a, b) of where its two ends are, seen from the body in between. Its gradient is all
   that L needs: l' = leaving.b' - entering.a', velocities relative to that body. Where the cable touches
   does not count (envelope theorem), and neither does what rotates there.                             */
#ifndef CARDSFLOW_WRAP_H
#define CARDSFLOW_WRAP_H

#include "real.h"

#include <stdint.h>

/* The most surfaces in one segment: the working memory of a sequence lies on the stack. */
#define LARGEST_SEQUENCE 8

/* Where a surface is now. */
typedef struct {
    int32_t kind;         /* enum surface */
    real radius;        /* in [m] */
    real half;          /* of a cylinder's length, in [m]; 0 if it has no ends */
    const real *centre; /* in the world */
    const real *axis;   /* z axis in the world */
} wrap_surface;

/* Which of the ways round a surface. */
typedef struct {
    int32_t side;      /* sense of turning about the axis; 0 for the shorter way, or WRAP_INSIDE */
    int32_t turns;     /* whole turns besides */
    int32_t is_counted; /* whether turns go on from move to move: of a cylinder only */
    real remembered; /* turning angle of the last move; NAN before the first */
} wrap_way;

/* Which directions of a pull are asked for. */
enum ends { ENTERING = 1, LEAVING = 2, BOTH_ENDS = ENTERING | LEAVING };

/* What a bent cable pulls. */
typedef struct {
    real length;      /* from a to b */
    real entering[3]; /* -dl/da: a unit vector from a to the surface, but for the cases in wrap.c */
    real leaving[3];  /* dl/db */
    real angle;       /* that it turns by in contact, in [rad]: above 0 where it touches */
    real turning;     /* from a to b about the axis, in [rad], with all turns; only if counted */
} pull;

/* How a cable passes a surface or a pulley. */
typedef struct {
    pull pull;                /* also where it runs free: along the straight line, with the angle 0 */
    real touch[3], lift[3]; /* where the contact begins and ends */
    real axis[3];           /* the contact turns about it */
} contact;

/* 1 and the pull where the cable touches the surface; 0 where it runs straight from a to b: then only the
   turning is set. Of `ends`, both directions or one; the other may be left as it is.                    */
int wrap_pull(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3], int ends,
              pull *out);

void wrap_over(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3],
               contact *out);

/* Whether the straight line from a to b clears the surface; or, for a way inside, passes through it. */
int wrap_is_clear(const wrap_surface *s, const wrap_way *way, const real a[3], const real b[3]);

/* The same three for a way inside a surface, which has no turns; `over` leaves a straight way to its caller. */
int wrap_inside_pull(const wrap_surface *s, const real a[3], const real b[3], pull *out);
int wrap_inside_over(const wrap_surface *s, const real a[3], const real b[3], contact *out);
int wrap_inside_is_clear(const wrap_surface *s, const real a[3], const real b[3]);

/* Off a swivelling pulley: from where the cable comes on, at F along the unit vector v, to b. */
void pulley_off(const real F[3], const real v[3], real radius, const real b[3], contact *out);

/* One part of a sequence: a pulley, which can only be the first, or a surface. */
typedef struct {
    const wrap_surface *surface; /* NULL: a pulley */
    wrap_way way;
    real v[3], radius; /* of a pulley */
} sequence_part;

/* The taut cable from `points[0]` to `points[count]` over parts in order; between two of them it passes
   one of the other points, which this finds.                                                          */
real sequence_solve(const sequence_part *parts, int count, real (*points)[3], contact *contacts);

#endif
