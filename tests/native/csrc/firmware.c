/* The controller of an example on a bare machine. Prints its use of memory and stack, and the forces of its
   ticks as bits. */
#include "bare_machine.h"
#include "example.h"
#include "example_loop.h"

#include <string.h>

enum { PAINTED = 16384, TICKS = 20 };
static const uint32_t PAINT = 0xdeadbeefu;

/* Fill the free stack with a pattern; later, return how much of it was overwritten. */
__attribute__((noinline)) static size_t stack(int look)
{
    volatile uint32_t *here = __builtin_frame_address(0), *at;
    const size_t words = PAINTED / 4, margin = 16;
    if (!look)
        for (at = here - words; at < here - margin; at++) *at = PAINT;
    for (at = here - words; at < here - margin && *at == PAINT; at++)
        ;
    return (size_t)(here - at) * 4;
}

void _start(void)
{
    static real q[COORDINATES], qd[COORDINATES], still[COORDINATES];
    size_t most = 0;
    if (example_open()) end(1);
    say_number("robot", robot_size);
    say_number("law", loop_size);
    for (int tick = 0; tick < TICKS; tick++) {
        for (size_t j = 0; j < COORDINATES; j++) {
            q[j] = START[j] + 0.01 * tick;
            qd[j] = 0.3 - 0.02 * tick;
        }
        stack(0);
        const int status = control_loop_tick(loop, PERIOD, q, qd, REFERENCE, still);
        const size_t used = stack(1);
        if (status >= COMPUTED_TORQUE_FAILED) end(1);
        most = used > most ? used : most;
    }
    say_number("stack", most);
    end(0);
}
