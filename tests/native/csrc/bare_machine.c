#include "bare_machine.h"

/* Arm's semihosting. Debuggers of Cortex-M use the breakpoint instruction; QEMU's user mode, which executes
   the same instructions as an application processor, uses the supervisor call. */
#if defined(CORTEX_M_SEMIHOSTING)
#define ASK "bkpt 0xab"
#else
#define ASK "svc 0xab"
#endif
enum { WRITE_TEXT = 0x04, EXIT = 0x18, APPLICATION_EXIT = 0x20026, RUN_TIME_ERROR = 0x20023 };

static void ask(int operation, unsigned long argument)
{
    register int r0 __asm__("r0") = operation;
    register unsigned long r1 __asm__("r1") = argument;
    __asm__ volatile(ASK : "+r"(r0) : "r"(r1) : "memory");
}

void say(const char *text)
{
    ask(WRITE_TEXT, (unsigned long)text);
}

void say_number(const char *what, unsigned long number)
{
    char digits[12], *at = digits + sizeof digits - 1;
    *at = 0;
    do *--at = (char)('0' + number % 10);
    while (number /= 10);
    say(what), say(" "), say(at), say("\n");
}

void end(int failed)
{
    ask(EXIT, failed ? RUN_TIME_ERROR : APPLICATION_EXIT);
    for (;;)
        ;
}
