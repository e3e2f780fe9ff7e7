/* Wait for a word of memory that another process writes. */
#ifndef WAITING_H
#define WAITING_H

#include <stdint.h>

/* Estimate of the usual waiting time: polling is useful if the answer is near. */
struct patience {
    double usual; /* in s */
};

/* Poll for a limited time, which may be almost zero. Return whether the word has the value. */
int wait_polling(const uint32_t *word, uint32_t value, const struct patience *patience);

/* Update the estimate with the duration of a wait, in s. */
void patience_learn(struct patience *patience, double waited);

#endif
