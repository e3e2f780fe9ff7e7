/* Reference motions: the positions, velocities and accelerations of r rows (coordinates or task coordinates)
   as functions of time.

   A part of a reference is at rest before time 0 and after its duration. Its numbers are in `data`:

     splines     begins of the segments and end of the last one (segments + 1); coefficients of the powers of the
                 time since the begin of a segment, lowest first (segments x powers x 3 x r); first and last position
     rose        centre, first and second axis (r each); radius R, petals k, maximum angle phi_end
     approach    start and displacement (r each) */
#ifndef CARDSFLOW_REFERENCE_H
#define CARDSFLOW_REFERENCE_H

#include "../qp/dual_newton.h" /* DUAL_NEWTON_API */

enum reference_kind { REFERENCE_SPLINES, REFERENCE_ROSE, REFERENCE_APPROACH, REFERENCE_KINDS };

typedef struct {
    size_t kind, r;
    real duration;           /* T, in [s] */
    size_t segments, powers; /* of splines, else 0 */
    const real *data;
} reference_part;

/* Return the number of elements of `data`; 0 if the part is invalid. */
uint64_t reference_part_length(const reference_part *part);

/* Evaluate consecutive parts, part i from begins[i] on, at given times in [s]: positions, velocities and
   accelerations; `rows` is times x 3 x r. */
DUAL_NEWTON_API void reference_evaluate(const reference_part *parts, const real *begins, size_t part_count,
                                        size_t time_count, const real *times, real *rows);

/* Time of a reference with a variable speed. A new speed is reached within a ramp, without jumps of the
   acceleration. At the speed 1 throughout, the lag is exactly 0. */
typedef struct {
    real lag;          /* real time minus the time of the reference, in [s] */
    real speed;        /* relative to the reference's own */
    real acceleration; /* its derivative, in [1/s] */
    real from, to, since; /* of the current ramp; since in [s] */
} path_time;

DUAL_NEWTON_API void path_time_reset(path_time *p);

/* Advance by h seconds towards a speed, with ramps of `ramp` seconds. */
DUAL_NEWTON_API void path_time_advance(path_time *p, real h, real speed, real ramp);

/* Change the velocities and accelerations of r evaluated rows to those with the variable speed. */
DUAL_NEWTON_API void path_time_scale(const path_time *p, size_t r, real *rows);

/* Functions of the files in this folder */

/* Compute s(u) = 10 u^3 - 15 u^4 + 6 u^5 of u = t/T, and its derivatives by t: s, s', s''. */
void quintic(real t, real T, real s[3]);

void splines_at(const reference_part *part, real t, real *rows);
void rose_at(const reference_part *part, real t, real *rows);
void approach_at(const reference_part *part, real t, real *rows);

#endif
