/* Waiting for a word of memory that another process writes. */
#ifndef WAITING_H
#define WAITING_H

#include <stdint.h>

/* Learns how long a wait usually takes: it pays to look on as long as the answer is near. */
struct patience {
    double usual; /* in s */
};

/* Whether the word took the value while it was polled; not for longer than makes sense, which may
 * be next to nothing. */
int wait_looking(const uint32_t *word, uint32_t value, const struct patience *patience);

/* Takes note of how long a wait took in all, in s. */
void patience_learn(struct patience *patience, double waited);

#endif
