/* Plant and controller of an example for a long time: endurance STEPS TICKS

   Runs STEPS of the plant, then TICKS of the closed loop at its reference. Prints the bytes of the heap in
   use before and after; the median, the 99.9th percentile and the maximum of the controller ticks in us, and
   the maximum without the time that other programs used; and the real-time factor of the loop. */
#include "example.h"
#include "example_loop.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double microseconds(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return 1e6 * (double)now.tv_sec + 1e-3 * (double)now.tv_nsec;
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void start(void)
{
    memcpy(robot_part("q"), START, sizeof START);
    memset(robot_part("qd"), 0, sizeof START);
    core_move(robot, robot_part("q"));
}

static int loop_once(void)
{
    static const double still[COORDINATES];
    size_t length;
    double q[COORDINATES], qd[COORDINATES];
    memcpy(q, robot_part("q"), sizeof q);
    memcpy(qd, robot_part("qd"), sizeof qd);
    const int status = control_loop_tick(loop, PERIOD, q, qd, REFERENCE, still);
    memcpy(robot_part("q"), q, sizeof q);
    core_move(robot, q);
    return status >= COMPUTED_TORQUE_FAILED || !control_loop_array(loop, "acting", &length);
}

int main(int argc, char **argv)
{
    if (argc != 3 || example_open()) return 2;
    const long steps = strtol(argv[1], NULL, 10), ticks = strtol(argv[2], NULL, 10);
    double max_work = 0, *durations = malloc((size_t)(ticks + 1) * sizeof *durations);
    size_t length;
    const double *acting = control_loop_array(loop, "acting", &length);
    if (!durations) return 2;
    start();
    const size_t before = mallinfo2().uordblks;
    for (long k = 0; k < steps; k++)
        if (core_step(robot, acting, NULL, PLANT_STEP, 1)) return 3;
    start();
    const double first = microseconds(CLOCK_MONOTONIC);
    for (long k = 0; k < ticks; k++) {
        const double begin = microseconds(CLOCK_MONOTONIC), work = microseconds(CLOCK_THREAD_CPUTIME_ID);
        if (loop_once()) return 4;
        const double cpu_time = microseconds(CLOCK_THREAD_CPUTIME_ID) - work;
        max_work = cpu_time > max_work ? cpu_time : max_work;
        durations[k] = microseconds(CLOCK_MONOTONIC) - begin;
        if (core_step(robot, acting, NULL, PLANT_STEP, PLANT_STEPS)) return 5;
    }
    const double factor = 1e6 * PERIOD * (double)ticks / (microseconds(CLOCK_MONOTONIC) - first);
    const size_t after = mallinfo2().uordblks;
    qsort(durations, (size_t)ticks, sizeof *durations, by_size);
    printf("%zu %zu\n%g %g %g %g\n%g\n", before, after, durations[ticks / 2],
           durations[(long)((double)ticks * 0.999)], durations[ticks - 1], max_work, factor);
    free(durations);
    return 0;
}
