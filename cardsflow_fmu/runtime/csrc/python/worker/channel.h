/* Commands from a host to its worker, and their answers, over shared memory.
 *
 * Clock and values lie in the memory and are everybody's, in turn: the host's until it asks, the
 * worker's until it answers. Bytes that go with a command or an answer are passed in parts. */
#ifndef CHANNEL_H
#define CHANNEL_H

#include "../../platform/text.h"
#include "system/bell.h"
#include "system/process.h"
#include "system/shared_memory.h"
#include "waiting.h"

#include <stddef.h>
#include <stdint.h>

enum command {
    COMMAND_PART, /* bytes that belong to the command that follows */
    COMMAND_NEXT, /* more bytes of the last answer */
    COMMAND_OPEN,
    COMMAND_INITIALIZE,
    COMMAND_STEP,
    COMMAND_RESET,
    COMMAND_TERMINATE,
    COMMAND_GET_STATE,
    COMMAND_SET_STATE,
    COMMAND_DERIVATIVE,
    COMMAND_QUIT
};

/* UNFIT: no model can run there; the bytes of an answer that is not DONE are a text. */
enum outcome { OUTCOME_DONE, OUTCOME_FAILED, OUTCOME_UNFIT };

struct bytes {
    unsigned char *at; /* on the heap, with a zero behind the last */
    size_t size;
};

struct channel_block;

struct channel {
    struct channel_block *block;
    struct patience patience;
    struct bytes bytes; /* host: of the last answer; worker: of the command, then of the answer */
    size_t sent;        /* worker: how much of the answer the host has */
};

/* Size of the memory for so many values. */
size_t channel_size(size_t count);

/* What both see. The block is cleared by the host before each start of a worker. */
void channel_attach(struct channel *channel, const struct shared_memory *memory);
void channel_clear(struct channel *channel, size_t count);
double *channel_clock(const struct channel *channel);
size_t channel_count(const struct channel *channel);

void channel_free(struct channel *channel);

/* Host: asks and waits for the answer, whose bytes are in `channel->bytes`. 0 once there is one, with
 * its outcome; nonzero with a message when the process has ended or the time has passed. */
int channel_ask(struct channel *channel, struct process *process, enum command command,
                const void *bytes, size_t size, double longest, enum outcome *outcome,
                struct text *error);

/* Host: asks the process to quit, without waiting. */
void channel_quit(struct channel *channel, struct process *process);

/* Worker: waits for the next command, whose bytes are in `channel->bytes`. */
enum command channel_next(struct channel *channel, const struct bell *bell);

/* Worker: answers it; takes the bytes over, which are on the heap or NULL. */
void channel_answer(struct channel *channel, const struct bell *bell, enum outcome outcome,
                    void *bytes, size_t size);

#endif
