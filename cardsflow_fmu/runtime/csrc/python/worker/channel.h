/* Commands from a host to its worker, and their answers, over shared memory.
 *
 * Clock and values are in the shared memory. The host may access them until it sends a command, the worker
 * until it answers. The bytes of a command or an answer are transferred in parts. */
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
    COMMAND_PART, /* bytes that belong to the following command */
    COMMAND_NEXT, /* more bytes of the last answer */
    COMMAND_OPEN,
    COMMAND_INITIALIZE,
    COMMAND_STEP,
    COMMAND_RESET,
    COMMAND_TERMINATE,
    COMMAND_GET_STATE,
    COMMAND_SET_STATE,
    COMMAND_QUIT
};

/* UNFIT: the process cannot run models. For all outcomes except DONE, the bytes of the answer are a text. */
enum outcome { OUTCOME_DONE, OUTCOME_FAILED, OUTCOME_UNFIT };

struct bytes {
    unsigned char *at; /* on the heap, zero-terminated */
    size_t size;
};

struct channel_block;

struct channel {
    struct channel_block *block;
    struct patience patience;
    struct bytes bytes; /* host: of the last answer; worker: of the command, then of the answer */
    size_t sent;        /* worker: number of bytes of the answer already sent */
};

/* Return the size of the memory for `count` values. */
size_t channel_size(size_t count);

/* Attach to the shared block. The host clears it before each start of a worker. */
void channel_attach(struct channel *channel, const struct shared_memory *memory);
void channel_clear(struct channel *channel, size_t count);
double *channel_clock(const struct channel *channel);
size_t channel_count(const struct channel *channel);

void channel_free(struct channel *channel);

/* Host: send a command and wait for the answer, whose bytes are in `channel->bytes`. Return 0 with its
 * outcome; or nonzero with a message if the process has ended or the time has expired. */
int channel_ask(struct channel *channel, struct process *process, enum command command,
                const void *bytes, size_t size, double longest, enum outcome *outcome,
                struct text *error);

/* Host: tell the process to quit, without waiting. */
void channel_quit(struct channel *channel, struct process *process);

/* Worker: wait for the next command, whose bytes are in `channel->bytes`. */
enum command channel_next(struct channel *channel, const struct bell *bell);

/* Worker: answer the command. The channel frees the bytes, which are on the heap or NULL. */
void channel_answer(struct channel *channel, const struct bell *bell, enum outcome outcome,
                    void *bytes, size_t size);

#endif
