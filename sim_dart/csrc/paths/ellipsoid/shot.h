/* Two tangents and a geodesic between them, by shooting. */
#ifndef CARDSFLOW_SHOT_H
#define CARDSFLOW_SHOT_H

#include "fan.h"
#include "geodesic.h"

/* An ellipsoid about the origin, and the ends of a cable; none of them is inside. */
typedef struct {
    real r[3], a[3], b[3]; /* half axes; ends */
    tangent_cone cones[2];
} cable_ends;

/* Contact point of a tangent: directions of the cable there and their derivatives by the angle. */
typedef struct {
    real x[3], t[3], m[3]; /* point, direction from a to b, perpendicular to it on the surface */
    real span;             /* length from the end */
    real by_t, by_m, turn; /* derivatives: of x along t and m, of t along m */
} tangent_at;

typedef struct {
    path_over way;
    tangent_at a, b;
    geodesic_point end;
    real gap[3], square; /* the three equations; the sum of their squares */
} shot;

/* Compute the tangents of both ends for the angles of a shot. */
CORE_INSIDE void shot_tangents(const cable_ends *e, shot *s);

/* Do the same, and follow the geodesic up to a last term: compute the equations. */
CORE_INSIDE void shot_follow(const cable_ends *e, real last_term, shot *s);

/* Compute Newton's step of alpha, beta and s. Return its size; infinite if it does not exist. */
CORE_INSIDE real shot_step(const shot *s, real step[3]);
CORE_INSIDE void shot_move(path_over *way, const real step[3], real part);

/* Return the length from end to end. */
CORE_INSIDE real shot_length(const shot *s);

#endif
