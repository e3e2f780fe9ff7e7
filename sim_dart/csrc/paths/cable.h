/* Curved parts of a cable: over one or several surfaces, or off a pulley.

   Each part has a length l(a, b) that depends on its two ends, relative to the body between them. L needs
   only its gradient: l' = leaving.b' - entering.a', with velocities relative to that body. Motion of the
   contact points and rotation of the body do not contribute (envelope theorem). */
#ifndef CARDSFLOW_CABLE_H
#define CARDSFLOW_CABLE_H

#include "../numbers/real.h"

#include <stdint.h>

/* Current pose of a surface. */
typedef struct {
    int32_t kind;         /* enum surface */
    real radius;        /* in [m] */
    real half;          /* of a cylinder's length, in [m]; 0 if it has no ends */
    const real *centre; /* in the world */
    const real *axis;   /* z axis in the world */
    const real *across; /* of an ellipsoid: its x axis in the world */
    const real *half_axes; /* half axes along y and z, in [m]; the half axis along x is the radius */
    real *stored;          /* of an ellipsoid: PATH_NUMBERS of its last path (see ellipsoid.c), or NULL */
} wrap_surface;

/* Selection of a path around a surface. */
typedef struct {
    int32_t side;      /* sense of turning about the axis; 0 for the shorter path, or WRAP_INSIDE; of an
                          ellipsoid, the touched half: 1, 2, 3 for x, y, z, negative for the opposite half, 0 for any */
    int32_t turns;     /* additional whole turns */
    int32_t is_followed; /* whether to compute the turning angle; cylinders only */
    int32_t is_forced; /* the cable uses that side even if the straight line is free */
    real remembered; /* if followed: nearby turning angle, which the cable continues, or NAN */
    const struct contact *from; /* of an ellipsoid: a nearby contact as the start of the search; or NULL */
} wrap_way;

/* Directions of a pull that must be computed. */
enum ends { ENTERING = 1, LEAVING = 2, BOTH_ENDS = ENTERING | LEAVING };

/* Length and directions of a curved cable. */
typedef struct {
    real length;      /* from a to b */
    real entering[3]; /* -dl/da: a unit vector from a to the surface, except in the cases in wrap.c */
    real leaving[3];  /* dl/db */
    real angle;       /* angle of contact in [rad]; above 0 if it touches; on an ellipsoid: the length */
    real turning;     /* from a to b about the axis, in [rad], with all turns; only if followed */
} pull;

/* Contact of a cable with a surface or a pulley. */
typedef struct contact {
    pull pull;                /* also without contact: along the straight line, with the angle 0 */
    real touch[3], lift[3]; /* where the contact begins and ends */
    real axis[3];           /* the contact turns about it */
} contact;

#endif
