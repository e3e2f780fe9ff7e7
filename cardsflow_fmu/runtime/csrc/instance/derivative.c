#include "derivative.h"

#include <math.h>
#include <stdlib.h>

/* Value references as indices of single values. */
struct indices {
    uint32_t *items;
    size_t count;
};

static enum status reject(struct instance *instance, const char *why)
{
    struct text text = {NULL};
    text_set(&text, "getDirectionalDerivative: %s", why);
    log_status(&instance->log, STATUS_ERROR, text_get(&text));
    text_free(&text);
    return STATUS_ERROR;
}

/* Return whether the reference refers to a real variable. */
static int is_real(const struct port_table *ports, uint32_t reference)
{
    return reference < ports->count && ports->ports[reference].size > 0 &&
           ports->ports[reference].type == PORT_REAL;
}

/* Read the elements of all variables; their number must be `expected`. Return NULL, or an error message. */
static const char *expand(const struct port_table *ports, const uint32_t *references, size_t count,
                          size_t expected, struct indices *indices)
{
    indices->count = 0;
    indices->items = malloc((expected + 1) * sizeof *indices->items);
    if (!indices->items)
        return "out of memory";
    for (size_t i = 0; i < count; i++) {
        if (!is_real(ports, references[i]))
            return "a value reference is not a real variable";
        size_t size = ports->ports[references[i]].size;
        if (size > expected - indices->count)
            return "too few seeds or sensitivities for the variables";
        for (size_t k = 0; k < size; k++)
            indices->items[indices->count++] = references[i] + (uint32_t)k;
    }
    return indices->count == expected ? NULL : "too many seeds or sensitivities for the variables";
}

static const char *check(const struct port_table *ports, const struct derivative *request)
{
    for (size_t i = 0; i < request->unknown_count; i++)
        if (ports->ports[request->unknowns[i]].causality != CAUSALITY_OUTPUT)
            return "an unknown is not an output";
    for (size_t i = 0; i < request->known_count; i++)
        if (!isfinite(request->seeds[i]))
            return "a seed is not finite";
    return NULL;
}

/* Compute the derivatives. Return NULL, or an error message. */
static const char *compute(struct instance *instance, const struct derivative *request)
{
    struct model *model = &instance->model;
    const char *wrong = check(&instance->ports, request);
    if (wrong)
        return wrong;
    if (!model->functions->derivative)
        return "this FMU has no directional derivatives";
    model->clock[0] = instance->time;
    model->clock[1] = instance->life_cycle & RUNNING ? instance->ports.step : 0;
    return model->functions->derivative(model, request) ? text_get(&model->error) : NULL;
}

enum status get_directional_derivative(struct instance *instance,
                                       const struct derivative_call *call)
{
    struct indices unknowns = {NULL, 0}, knowns = {NULL, 0};
    if (!instance_allows(instance, "getDirectionalDerivative", INITIALIZATION_MODE | RUNNING) ||
        instance_update(instance) != STATUS_OK)
        return STATUS_ERROR;
    const char *wrong = expand(&instance->ports, call->unknowns, call->unknown_count,
                               call->answer_count, &unknowns);
    if (!wrong)
        wrong = expand(&instance->ports, call->knowns, call->known_count, call->seed_count,
                       &knowns);
    struct derivative request = {unknowns.count, unknowns.items, knowns.count,
                                 knowns.items,   call->seeds,    call->answers};
    if (!wrong)
        wrong = compute(instance, &request);
    free(unknowns.items);
    free(knowns.items);
    return wrong ? reject(instance, wrong) : STATUS_OK;
}
