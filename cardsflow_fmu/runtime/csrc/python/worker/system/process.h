/* A process that works for this one, over shared memory and a bell. */
#ifndef PROCESS_H
#define PROCESS_H

#include "../../../platform/text.h"
#include "bell.h"
#include "shared_memory.h"

struct process {
    struct bell bell;
    int is_running;
#ifdef _WIN32
    void *handle, *job;
#else
    long id, owner; /* owner: who started it */
    int status; /* as of waitpid, once it runs no more */
#endif
};

/* Starts a program with `arguments`, its own name not among them, NULL behind the last, and one more
 * behind them for process_attach. A name without a slash is looked for as a shell does. 0, or nonzero
 * with a message. */
int process_start(struct process *process, const char *program, const char *const arguments[],
                  const struct shared_memory *memory, struct text *error);

/* Whether this process has started it, and is no copy of the one that has, made by fork. */
int process_is_own(const struct process *process);

/* Whether it has ended by itself, or does so within some seconds, and how. */
int process_has_ended(struct process *process, double seconds, struct text *how);

/* Waits for its end, for a time at most, then ends it. Nothing of it is left. Another's continues. */
void process_end(struct process *process, double patience);

/* In the process that was started: finds memory and bell by the last argument. From then on this
 * process ends as soon as the other one has. 0, or nonzero. */
int process_attach(const char *argument, struct shared_memory *memory, struct bell *bell);

/* Path of the file that holds this function, in UTF-8, on the heap; NULL when that is unknown. */
char *process_own_library(void);

#endif
