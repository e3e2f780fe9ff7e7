/* Opens damaged robot blobs: fuzz_blobs FIRST COUNT BLOB...

   Each blob is either rejected with a message, or is a robot that can be moved, evaluated and stepped.
   Prints the number of rejected blobs. The program is compiled with sanitizers, which end it on any error. */
#include "mutate.h"
#include "sim_dart/csrc/core.h"
#include "sim_dart/csrc/tangent/tangent.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static real *array(core *c, const char *name, size_t *length)
{
    return core_array(c, name, length);
}

/* Return values that can occur in a simulation, and occasionally invalid ones. */
static real *numbers(uint64_t *state, size_t count)
{
    const real odd[] = {NAN, INFINITY, -INFINITY, PRECISE(1e300, 1e37), 1e9, -1e9, 0};
    real *values = malloc((count + !count) * sizeof *values);
    if (!values) exit(2);
    const int is_invalid = draw(state) % 8 == 0;
    for (size_t i = 0; i < count; i++)
        values[i] = is_invalid && draw(state) % 4 == 0 ? odd[draw(state) % 7] : (real)(draw(state) >> 40) / 5e6 - 1.5;
    return values;
}

static void use_laws(core *c, const real *qd, const real *u)
{
    core_start(c, u);
    core_drive(c, qd, u);
    core_law_rates(c, u);
    core_reach(c, 1e-3);
    core_invert(c, u, 4e-3, 1e-3);
    core_advance(c, u, 1e-3);
}

/* Step with derivatives, from the current state and forces; only in double precision. */
static void step_with_tangents(core *c, const real *f, const real *wrenches, const real *dq, const real *dqd)
{
#if !defined(CARDSFLOW_FLOAT)
    size_t n, m;
    const size_t size = core_tangent_size(c);
    void *memory = size < (size_t)1 << 24 ? malloc(size) : NULL;
    const double *q = array(c, "q", &n), *qd = array(c, "qd", &n);
    double *changes = array(c, "lengths", &m);
    if (!memory) return;
    core_tangent *a = core_tangent_open(c, memory);
    core_tangent_set(a, TANGENT_Q, q, dq);
    core_tangent_set(a, TANGENT_QD, qd, dqd);
    core_tangent_set(a, TANGENT_COMMANDS, f, f);
    core_tangent_set(a, TANGENT_WRENCHES, wrenches, wrenches);
    if (!core_tangent_move(a)) {
        core_tangent_start(a);
        core_tangent_step(a, 1e-3, 2);
        core_tangent_runge_kutta(a, 1e-3, 1);
        core_tangent_drive(a);
        core_tangent_energies(a);
        core_tangent_changes(a, TANGENT_LENGTHS, changes);
    }
    free(memory);
#else
    (void)c, (void)f, (void)wrenches, (void)dq, (void)dqd;
#endif
}

static void use(core *c, uint64_t *state)
{
    size_t n, m;
    real *own_q = array(c, "q", &n), *own_qd = array(c, "qd", &n);
    array(c, "lengths", &m);
    real *q = numbers(state, n), *qd = numbers(state, n), *f = numbers(state, m);
    real *points = numbers(state, 6), *wrenches = numbers(state, 12);
    if (!core_move_checked(c, q, qd)) {
        memcpy(own_q, q, n * sizeof(real));
        memcpy(own_qd, qd, n * sizeof(real));
        core_step(c, f, NULL, 1e-3, 3);
    }
    if (!core_move_checked(c, q, qd)) {
        const int32_t frames[2] = {-1, (int32_t)n - 1};
        memcpy(own_q, q, n * sizeof(real));
        memcpy(own_qd, qd, n * sizeof(real));
        if (core_external_wrenches(c, 2, frames, points, wrenches)) exit(3);
        core_runge_kutta(c, f, qd, 1e-3, 3);
        step_with_tangents(c, f, wrenches, q, qd);
        core_external_wrenches(c, 0, frames, points, wrenches);
        core_energies(c, qd);
    }
    core_move(c, q);
    core_pull(c, f);
    core_task_jacobian(c);
    core_task_bias(c, qd);
    core_mass_matrix(c);
    core_coriolis(c, qd);
    core_gravity(c);
    size_t variables;
    array(c, "variables", &variables);
    real *armature = numbers(state, variables);
    core_accelerate(c, qd, qd, armature);
    free(armature);
    int32_t *sizes = malloc((m + 1) * sizeof *sizes);
    core_lines(c, sizes, NULL, 0);
    free(sizes);
    use_laws(c, qd, f);
    free(q), free(qd), free(f), free(points), free(wrenches);
}

static int is_rejected(unsigned char *blob, size_t size, uint64_t *state)
{
    char message[64] = "";
    const size_t needed = core_size(blob, size, message, sizeof message);
    if (needed > (size_t)1 << 28) { /* a large but valid robot */
        free(blob);
        return 0;
    }
    if (!needed && !*message) exit(3); /* rejected without a message */
    void *memory = needed ? malloc(needed) : NULL;
    if (needed) {
        core *c = core_open(blob, size, memory);
        if (!c) exit(4);
        use(c, state);
    }
    free(memory), free(blob);
    return !needed;
}

#if defined(CARDSFLOW_LIBFUZZER)
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint64_t state = size;
    unsigned char *blob = malloc(size + !size); /* with exactly its size */
    if (!blob) return 0;
    memcpy(blob, data, size);
    is_rejected(blob, size, &state);
    return 0;
}
#else
int main(int argc, char **argv)
{
    unsigned long rejected = 0;
    if (argc < 4) return 2;
    const unsigned long first = strtoul(argv[1], NULL, 10), count = strtoul(argv[2], NULL, 10);
    for (unsigned long number = first; number < first + count; number++) {
        size_t size;
        uint64_t state = number;
        unsigned char *contents = file_contents(argv[3 + draw(&state) % (uint64_t)(argc - 3)], &size);
        unsigned char *blob = mutated(&state, contents, &size, 0);
        rejected += (unsigned long)is_rejected(blob, size, &state);
        free(contents);
    }
    printf("%lu\n", rejected);
    return 0;
}
#endif
