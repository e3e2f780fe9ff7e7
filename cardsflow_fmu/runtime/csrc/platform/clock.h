/* The clock that times are measured by. */
#ifndef CLOCK_H
#define CLOCK_H

/* Seconds on a clock that only goes forward. */
double monotonic_seconds(void);

#endif
