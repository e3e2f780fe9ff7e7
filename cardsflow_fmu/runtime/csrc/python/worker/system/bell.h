/* Wake-up signals between two processes, which also detect the end of the other process. */
#ifndef BELL_H
#define BELL_H

struct bell {
#ifdef _WIN32
    void *mine, *others; /* the event to wait for, the event to set */
    void *peer;          /* the other process */
#else
    int socket; /* a byte is a ring; the end of the stream is the end of the other process */
#endif
};

enum bell_answer { BELL_RUNG, BELL_SILENT, BELL_GONE };

/* Wake the other process. Rings without a waiting receiver are stored or lost; this call never blocks. */
void bell_ring(const struct bell *bell);

/* Wait for a ring, for a maximum time. A ring may be an old one. */
enum bell_answer bell_wait(const struct bell *bell, double seconds);

void bell_close(struct bell *bell);

#endif
