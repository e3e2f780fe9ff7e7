/* Monotonic clock. */
#ifndef CLOCK_H
#define CLOCK_H

/* Return seconds on a clock that never goes backwards. */
double monotonic_seconds(void);

#endif
