/* The core handle: its memory and arrays, and the calls of a step. */
#include "blob/blob.h"
#include "kinematics/tree.h"
#include "laws/laws.h"
#include "paths/paths.h"

#include <string.h>

static size_t working_size(const blob_view *view)
{
    return padded(sizeof(core)) + state_reals(view) * sizeof(real);
}

static int open_view(blob_view *view, const void *blob, size_t size, char *message, size_t capacity)
{
    return blob_open(view, blob, size, message, capacity) || laws_check(view, message, capacity);
}

size_t core_size(const void *blob, size_t size, char *message, size_t capacity)
{
    blob_view view;
    return open_view(&view, blob, size, message, capacity) ? 0 : working_size(&view);
}

core *core_open(const void *blob, size_t size, void *memory)
{
    blob_view view;
    if (!memory || (uintptr_t)memory % 8 || open_view(&view, blob, size, NULL, 0)) return NULL;
    memset(memory, 0, working_size(&view));
    core *s = memory;
    s->blob = view;
    STATE_LENGTHS(&view)
    real *at = (real *)(void *)((char *)memory + padded(sizeof *s));
    STATE_ARRAYS(NAMED_PLACE)
    for (int32_t k = 0; k < view.counts.muscles; k++) s->has_laws |= view.law_kind[k] != KIND_ideal;
    for (int32_t k = 0; k < view.counts.muscles; k++) s->tension_scale[k] = 1;
    s->has_laws |= view.counts.bends > 0;
    s->is_driven = wide > 0;
    for (int32_t j = 0; j < view.counts.dofs; j++) s->has_friction |= view.friction[j] != 0;
    for (int32_t l = 0; l < view.counts.limit_forces && !s->has_friction; l++)
        s->has_soft_limits |= view.limit_numbers[LIMIT_NUMBERS * l + 6] > 0;
    tree_prepare(s);
    paths_prepare(s);
    laws_prepare(s);
    return s;
}

real *core_array(core *c, const char *name, size_t *length)
{
    STATE_LENGTHS(&c->blob)
    (void)bends, (void)law_constants, (void)terms, (void)wide, (void)conditions, (void)moves;
    const struct {
        const char *name;
        real *array;
        size_t length;
    } arrays[] = {
        {"lengths", c->lengths, muscles},
        {"jacobian", c->jacobian, muscles * dofs},
        {"torques", c->torques, dofs},
        {"task_values", c->task_values, 3 * tasks},
        {"task_jacobian", c->task_jacobian, 3 * tasks * dofs},
        {"points", c->point, 3 * points},
        {"surface_places", c->surface_place, 6 * surfaces},
        {"surface_across", c->surface_across, 3 * surfaces},
        {"wrap_contacts", c->wrap_contact, CONTACT_NUMBERS * wraps},
        {"pulley_contacts", c->pulley_contact, CONTACT_NUMBERS * pulleys},
        {"wrap_before", c->wrap_before, wraps},
        {"wrap_rank", c->wrap_rank, wraps},
        {"point_share", c->point_share, points},
        {"rates", c->rates, muscles},
        {"variables", c->at, variables},
        {"tension_scale", c->tension_scale, muscles},
        {"tensions", c->tensions, muscles},
        {"law_states", c->law_states, law_states},
        {"law_rates", c->law_rates, law_states},
        {"far_tensions", c->far_tensions, bends ? muscles : 0},
        {"pull_jacobian", c->pull_jacobian, bends ? muscles * dofs : 0},
        {"bend_flow", c->bend_flow, bends * dofs},
        {"bend_grip", c->bend_grip, bends},
        {"force_low", c->force_low, muscles},
        {"force_high", c->force_high, muscles},
        {"commands", c->commands, muscles},
        {"closure_gap", c->closure_gap, closures},
        {"closure_jacobian", c->closure_jacobian, closures * dofs},
        {"closure_bias", c->closure_bias, closures},
        {"free_motion", c->free_motion, closures ? dofs * dofs : 0},
        {"free_bias", c->free_bias, closures ? dofs : 0},
        {"task_bias", c->task_bias, 3 * tasks},
        {"mass_matrix", c->mass_matrix, dofs * dofs},
        {"coriolis", c->coriolis, dofs},
        {"gravity", c->gravity, dofs},
        {"qdd", c->qdd, dofs},
        {"held", c->held, dofs},
        {"hold_force", c->hold_force, dofs},
        {"q", c->q, dofs},
        {"qd", c->qd, dofs},
        {"outer", c->outer, dofs},
        {"work", c->work, 4},
        {"energies", c->energies, 3},
        {"momenta", c->momenta, 6},
        {"frame_rotation", c->rotation, 9 * frames},
        {"frame_origin", c->origin, 3 * frames},
        {"frame_axis", c->axis, 3 * frames},
    };
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        if (!strcmp(arrays[k].name, name)) return *length = arrays[k].length, arrays[k].array;
    return NULL;
}

const real *core_coordinates(const core *c, const char *field)
{
    const blob_view *blob = &c->blob;
    return !strcmp(field, "damping") ? blob->damping
           : !strcmp(field, "friction") ? blob->friction
           : !strcmp(field, "lower") ? blob->lower
           : !strcmp(field, "upper") ? blob->upper
                                     : NULL;
}
