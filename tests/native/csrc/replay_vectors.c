/* Replays vectors through the core and the control laws.

   The vectors are a list of records, see vector_file.py. Each comparison prints a line: the digest of the
   resulting bits, and the name. The program uses the same part of the C library as core and laws, so that it
   also runs on a bare machine. */
#include "replay_vectors.h"

#include "robot_terms.h"
#include "sim_dart/csrc/numbers/real_functions.h"

#include <math.h>
#include <string.h>

typedef struct {
    char name[48];
    real tolerance;
    whole_number count; /* of numbers */
} record;

static core *robot;
static dual_newton *program;
static control_loop *loop;
static size_t n, m, k; /* coordinates, muscles, controlled task coordinates */
static real *positions, *forces; /* at every tick of the last run */
static size_t ticks;

static real *allocate_reals(size_t count)
{
    return allocate((count + 1) * sizeof(real));
}

/* --------------------------------------------------------------------------------- named arrays */

static real *core_part(const char *name)
{
    size_t length;
    return core_array(robot, name, &length);
}

static real *find(const char *name, size_t *length)
{
    real *found = NULL;
    if (!strncmp(name, "core.", 5)) found = core_array(robot, name + 5, length);
    if (!strncmp(name, "program.", 8)) found = dual_newton_array(program, name + 8, length);
    if (!strncmp(name, "loop.", 5)) found = control_loop_array(loop, name + 5, length);
    if (!strcmp(name, "run.q")) *length = ticks * n, found = positions;
    if (!strcmp(name, "run.forces")) *length = ticks * m, found = forces;
    if (!found) fail("unknown array", name);
    return found;
}

static void set(const char *name, const real *values, uint64_t count)
{
    size_t length;
    real *array = find(name, &length);
    if (length != count) fail("has another size", name);
    memcpy(array, values, length * sizeof(real));
}

/* FNV-1a of the bits, lowest byte first. */
static uint64_t digest(const real *values, size_t count)
{
    uint64_t hash = 14695981039346656037u, bits = 0;
    for (size_t i = 0; i < count; i++) {
        memcpy(&bits, values + i, sizeof *values);
        for (size_t byte = 0; byte < sizeof *values; byte++) hash = (hash ^ (bits >> 8 * byte & 255)) * 1099511628211u;
    }
    return hash;
}

static int compare(const char *name, const real *expected, uint64_t count, real tolerance)
{
    size_t length;
    const real *array = find(name, &length);
    real scale = 0;
    int failed = 0;
    if (length != count) fail("has another size", name);
    for (size_t i = 0; i < length; i++) scale = fabs(expected[i]) > scale ? fabs(expected[i]) : scale;
    for (size_t i = 0; i < length; i++) failed |= !(fabs(array[i] - expected[i]) <= tolerance * scale);
    char line[17] = "";
    const uint64_t bits = digest(array, length);
    for (int k = 0; k < 16; k++) line[k] = "0123456789abcdef"[bits >> (60 - 4 * k) & 15];
    say(line), say(failed ? " deviates: " : " "), say(name), say("\n");
    return failed;
}

/* --------------------------------------------------------------------------------------- the robot */

static void open_robot(const real *blob, uint64_t count)
{
    char message[256] = "";
    const size_t size = core_size(blob, (size_t)count * sizeof(real), message, sizeof message);
    if (!size) fail(message, "robot");
    robot = core_open(blob, (size_t)count * sizeof(real), allocate(size));
    core_array(robot, "q", &n);
    core_array(robot, "lengths", &m);
}

/* Compute all quantities at q, qd and muscle forces f; `coriolis` then contains C + G. */
static void evaluate_all(const real *q, const real *qd, const real *f)
{
    real *none = allocate_reals(n);
    memset(none, 0, n * sizeof(real));
    if (core_move_checked(robot, q, qd) || core_pull(robot, f)) fail("a number is not finite", "state");
    core_task_jacobian(robot);
    core_task_bias(robot, qd);
    core_mass_matrix(robot);
    core_gravity(robot);
    core_bias(robot, qd);
    core_accelerate(robot, qd, core_part("torques"), none);
}

/* ---------------------------------------------------------------------------------- the closed loop */

static void open_loop(const real *rows, uint64_t count)
{
    static robot_and_rows own;
    const control_robot asked = {&own, terms, tasks, NULL, NULL, NULL};
    k = (size_t)count;
    own = (robot_and_rows){robot, rows, k};
    loop = control_loop_open(&asked, (int)n, (int)m, (int)k, allocate(control_loop_size((int)n, (int)m, (int)k)));
}

/* values: period; step of the plant; number of steps per period; q, qd at the start; reference of every tick */
static void run(const real *values, uint64_t count)
{
    const size_t r = k ? k : n;
    const real period = values[0], step = values[1], *reference = values + 3 + 2 * n;
    real *q = allocate_reals(n), *qd = allocate_reals(n), *still = allocate_reals(n);
    size_t length;
    ticks = ((size_t)count - 3 - 2 * n) / (3 * r);
    positions = allocate_reals(ticks * n), forces = allocate_reals(ticks * m);
    memset(still, 0, n * sizeof(real));
    memcpy(q, values + 3, n * sizeof(real));
    memcpy(qd, values + 3 + n, n * sizeof(real));
    control_loop_reset(loop);
    for (size_t t = 0; t < ticks; t++) {
        if (control_loop_tick(loop, period, q, qd, reference + 3 * r * t, still) >= COMPUTED_TORQUE_FAILED)
            fail("the law failed", "run");
        const real *acting = control_loop_array(loop, "acting", &length);
        memcpy(core_part("q"), q, n * sizeof(real));
        memcpy(core_part("qd"), qd, n * sizeof(real));
        core_move(robot, q);
        if (core_step(robot, acting, NULL, step, (int32_t)values[2])) fail("the plant diverged", "run");
        memcpy(q, core_part("q"), n * sizeof(real));
        memcpy(qd, core_part("qd"), n * sizeof(real));
        memcpy(positions + t * n, q, n * sizeof(real));
        memcpy(forces + t * m, acting, m * sizeof(real));
    }
}

/* ------------------------------------------------------------------------------------- the vectors */

static int replay(const record *head, const real *values)
{
    const char *name = head->name;
    const uint64_t count = (uint64_t)head->count;
    if (!strncmp(name, "set ", 4))
        set(name + 4, values, count);
    else if (!strncmp(name, "expect ", 7))
        return compare(name + 7, values, count, head->tolerance);
    else if (!strcmp(name, "robot"))
        open_robot(values, count);
    else if (!strcmp(name, "state"))
        evaluate_all(values, values + n, values + 2 * n);
    else if (!strcmp(name, "program")) {
        program = dual_newton_open((int)values[0], (int)values[1],
                                   allocate(dual_newton_size((int)values[0], (int)values[1])));
    } else if (!strcmp(name, "solve")) {
        if (dual_newton_solve(program) != DUAL_NEWTON_SOLVED) fail("is not solved", name);
    } else if (!strcmp(name, "loop"))
        open_loop(values, count);
    else if (!strcmp(name, "run"))
        run(values, count);
    else
        fail("unknown record", name);
    return 0;
}

int replay_vectors(const char *bytes, size_t size)
{
    int failed = 0;
    for (size_t at = 0; at < size;) {
        const record *head = (const record *)(const void *)(bytes + at);
        failed |= replay(head, (const real *)(const void *)(head + 1));
        at += sizeof *head + ((size_t)head->count * sizeof(real) + 7) / 8 * 8;
    }
    return failed;
}
