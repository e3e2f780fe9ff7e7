/* Control along an optimal motion: u = u* + K (x* - x), with u* and K held from the time of each row to the
   next one. The functions do not allocate memory and have no global state. */
#ifndef CARDSFLOW_HELD_MOTION_H
#define CARDSFLOW_HELD_MOTION_H

#include "../qp/dual_newton.h" /* real */

typedef struct {
    size_t rows, actuators, controls, states, extra; /* extra: states in the rows, the last ones of x */
    const real *begins; /* time of each row, in [s], increasing */
    const real *values; /* rows x (forces, actuators; u*, controls; x* of the extra states; K, controls x states) */
} held_motion;

/* Return the number of values of a row. */
size_t held_motion_width(const held_motion *motion);

/* Return the values of the last row that begins at the time or before. */
const real *held_motion_row(const held_motion *motion, real time);

/* Compute u, controls. `deviation` is x* - x, states; that of the extra states is computed from `extra`, their
   values, by linear interpolation of the rows, and stored. */
void held_motion_control(const held_motion *motion, real time, const real *extra, real *deviation, real *u);

#endif
