/* A child process that is connected by shared memory and a bell. */
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
    long id, owner; /* owner: process that started it */
    int status; /* as from waitpid, after its end */
#endif
};

/* Start a program with `arguments`, without its name and ending with NULL, and one further argument for
 * process_attach. A name without a slash is searched like in a shell. Return 0, or nonzero with a message. */
int process_start(struct process *process, const char *program, const char *const arguments[],
                  const struct shared_memory *memory, struct text *error);

/* Return whether this process started it, and is not a forked copy of that process. */
int process_is_child(const struct process *process);

/* Return whether it has ended, or ends within some seconds, and how. */
int process_has_ended(struct process *process, double seconds, struct text *how);

/* Wait for its end, for a maximum time, then kill it and release all resources. A process that another
 * process started continues. */
void process_end(struct process *process, double patience);

/* In the started process: find memory and bell by the last argument. From then on this process ends when its
 * parent ends. Return 0, or nonzero. */
int process_attach(const char *argument, struct shared_memory *memory, struct bell *bell);

/* Return the path of the file that contains this function, in UTF-8, on the heap; NULL if it is unknown. */
char *process_own_library(void);

#endif
