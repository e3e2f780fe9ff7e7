/* How two processes wake each other, and how each learns of the other's end. */
#ifndef BELL_H
#define BELL_H

struct bell {
#ifdef _WIN32
    void *mine, *others; /* the event to wait for, the event to set */
    void *peer;          /* the other process */
#else
    int socket; /* a byte is a ring; the end of the stream is the other's end */
#endif
};

enum bell_answer { BELL_RUNG, BELL_SILENT, BELL_GONE };

/* Wakes the other one; rings that nobody waits for are kept or lost, never waited for. */
void bell_ring(const struct bell *bell);

/* Waits for a ring, for a time at most. A ring may be an old one. */
enum bell_answer bell_wait(const struct bell *bell, double seconds);

void bell_close(struct bell *bell);

#endif
