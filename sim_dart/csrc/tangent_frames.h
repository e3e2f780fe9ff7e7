/* How the frames of a tree, their accelerations and wrenches change along a direction.

   All vectors are in the world. A frame that turns by a small angle d and whose origin moves by s takes
   everything that it carries along: a vector v of it changes by d x v.                                  */
#ifndef CARDSFLOW_TANGENT_FRAMES_H
#define CARDSFLOW_TANGENT_FRAMES_H

#include "spatial.h"

/* Of every frame: how it turned, how its origin moved; changes of link and axis; spin, acceleration and
   wrench, each with its change.                                                                         */
typedef struct {
    real turn[3], shift[3], link[3], axis[3];
    real spin[3], spin_change[3];
    real motion[6], motion_change[6];
    real wrench[6], wrench_change[6];
} frame;

/* turn, shift, link and axis for a change of q, at the core's last q. */
void tangent_displace(const core *c, frame *frames, const real *dq);

/* How a point moves that a displaced frame carries; -1 is the world. */
void tangent_point(const core *c, const frame *frames, int32_t i, const real point[3], real out[3]);

/* No wrenches yet. */
void tangent_forget(const core *c, frame *frames);

/* A force on a point of a frame: off the wrench that the frame asks for. */
void tangent_apply(const core *c, frame *frames, int32_t i, const real point[3], const real force[3],
                   const real force_change[3]);

/* How the generalised forces change that a motion asks for at constant accelerations, in a world that is
   accelerated by `up`; the frames are displaced, and their wrenches hold the forces that act. The core's
   link, centre and moment are those of its last q.                                                      */
void tangent_ask(const core *c, frame *frames, const real up[3], const real *qd, const real *dqd,
                 const real *qdd, real *out);

#endif
