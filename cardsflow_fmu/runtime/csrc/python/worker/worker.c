/* The worker side: functions that Python calls in a process that the host has started. */
#include "../../model/model.h"
#include "../../platform/text.h"
#include "../in_process.h"
#include "channel.h"
#include "system/process.h"

#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define WORKER_EXPORT __declspec(dllexport)
#else
#define WORKER_EXPORT __attribute__((visibility("default")))
#endif

/* Run the model in `resources` for the host, until the host sends the command to quit. Return 0, or nonzero
 * without a host. */
WORKER_EXPORT int cardsflow_worker_run(const char *links, const char *resources,
                                       const char *version);

/* Report to the host why this process cannot run models. */
WORKER_EXPORT int cardsflow_worker_reject(const char *links, const char *reason);

struct worker {
    struct shared_memory memory;
    struct bell bell;
    struct channel channel;
};

static int attach(struct worker *worker, const char *links)
{
    if (process_attach(links, &worker->memory, &worker->bell))
        return 1;
    channel_attach(&worker->channel, &worker->memory);
    return 0;
}

static void answer_text(struct worker *worker, enum outcome outcome, const char *text)
{
    char *copy = text_copy(text);
    channel_answer(&worker->channel, &worker->bell, outcome, copy, copy ? strlen(copy) : 0);
}

int cardsflow_worker_reject(const char *links, const char *reason)
{
    struct worker worker;
    if (attach(&worker, links))
        return 1;
    while (channel_next(&worker.channel, &worker.bell) != COMMAND_QUIT)
        answer_text(&worker, OUTCOME_UNFIT, reason);
    return 0;
}

static int execute(struct model *model, enum command command, const struct bytes *bytes,
                   void **answer, size_t *size)
{
    switch (command) {
    case COMMAND_INITIALIZE:
        return model->functions->initialize(model);
    case COMMAND_STEP:
        return model->functions->step(model);
    case COMMAND_RESET:
        return model->functions->reset(model);
    case COMMAND_TERMINATE:
        return model->functions->terminate(model);
    case COMMAND_GET_STATE:
        return model->functions->get_state(model, answer, size);
    case COMMAND_SET_STATE:
        return model->functions->set_state(model, bytes->at, bytes->size);
    default:
        text_set(&model->error, "unknown command %d", (int)command);
        return 1;
    }
}

/* Answer commands until the host sends the command to quit. */
static void serve(struct worker *worker, struct model *model)
{
    for (;;) {
        void *answer = NULL;
        size_t size = 0;
        enum command command = channel_next(&worker->channel, &worker->bell);
        if (command == COMMAND_QUIT)
            return;
        if (execute(model, command, &worker->channel.bytes, &answer, &size)) {
            free(answer);
            answer_text(worker, OUTCOME_FAILED, text_get(&model->error));
        } else {
            channel_answer(&worker->channel, &worker->bell, OUTCOME_DONE, answer, size);
        }
    }
}

int cardsflow_worker_run(const char *links, const char *resources, const char *version)
{
    struct worker worker;
    struct model model;
    struct text error = {NULL};
    memset(&model, 0, sizeof model);
    if (attach(&worker, links) || channel_next(&worker.channel, &worker.bell) != COMMAND_OPEN)
        return 1;
    struct python_memory memory = {channel_clock(&worker.channel), channel_count(&worker.channel)};
    if (python_in_process_open(&model, version, &memory, resources, &error)) {
        answer_text(&worker, OUTCOME_FAILED, text_get(&error));
        text_free(&error);
        channel_next(&worker.channel, &worker.bell);
        return 0;
    }
    channel_answer(&worker.channel, &worker.bell, OUTCOME_DONE, NULL, 0);
    serve(&worker, &model);
    model.functions->close(&model);
    text_free(&model.error);
    channel_free(&worker.channel);
    return 0;
}
