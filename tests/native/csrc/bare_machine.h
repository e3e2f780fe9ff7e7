/* A Cortex-M7 without an operating system: it starts, reports results to the debugger, and ends. */
#ifndef BARE_MACHINE_H
#define BARE_MACHINE_H

void say(const char *text);
void say_number(const char *what, unsigned long number);
__attribute__((noreturn)) void end(int failed);

#endif
