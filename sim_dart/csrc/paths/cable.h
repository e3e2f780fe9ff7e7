/* The ways of a cable that are not straight: over a surface, over several, off a pulley.

   Each is a length l(a, b) of where its two ends are, seen from the body in between. Its gradient is all
   that L needs: l' = leaving.b' - entering.a', velocities relative to that body. Where the cable touches
   does not count (envelope theorem), and neither does what rotates there.                             */
#ifndef CARDSFLOW_CABLE_H
#define CARDSFLOW_CABLE_H

#include "../numbers/real.h"

#include <stdint.h>

/* Where a surface is now. */
typedef struct {
    int32_t kind;         /* enum surface */
    real radius;        /* in [m] */
    real half;          /* of a cylinder's length, in [m]; 0 if it has no ends */
    const real *centre; /* in the world */
    const real *axis;   /* z axis in the world */
    const real *across; /* of an ellipsoid: its x axis in the world */
    const real *half_axes; /* its half axes along y and z, in [m]; that along x is the radius */
} wrap_surface;

/* Which of the ways round a surface. */
typedef struct {
    int32_t side;      /* sense of turning about the axis; 0 for the shorter way, or WRAP_INSIDE; of an ellipsoid
                          the half that it touches, 1, 2, 3 for x, y, z, below 0 for the other one; 0 for any */
    int32_t turns;     /* whole turns besides */
    int32_t is_counted; /* whether turns continue from move to move: of a cylinder only */
    int32_t is_forced; /* that side in any case, whether or not the straight line is clear */
    real remembered; /* turning angle of the last move; NAN before the first */
    const struct contact *from; /* of an ellipsoid: a contact nearby, where the search begins; NULL for none */
} wrap_way;

/* Which directions of a pull are asked for. */
enum ends { ENTERING = 1, LEAVING = 2, BOTH_ENDS = ENTERING | LEAVING };

/* What a bent cable pulls. */
typedef struct {
    real length;      /* from a to b */
    real entering[3]; /* -dl/da: a unit vector from a to the surface, but for the cases in wrap.c */
    real leaving[3];  /* dl/db */
    real angle;       /* that it turns by in contact, in [rad]: above 0 if it touches; on an ellipsoid its way */
    real turning;     /* from a to b about the axis, in [rad], with all turns; only if counted */
} pull;

/* How a cable passes a surface or a pulley. */
typedef struct contact {
    pull pull;                /* also where it runs free: along the straight line, with the angle 0 */
    real touch[3], lift[3]; /* where the contact begins and ends */
    real axis[3];           /* the contact turns about it */
} contact;

#endif
