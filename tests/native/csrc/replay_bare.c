/* The replay on a bare machine: the vectors are part of the program; VECTORS is their file. */
#include "bare_machine.h"
#include "replay_vectors.h"

#include <stdint.h>

__asm__(".section .rodata\n.balign 8\nvectors:\n.incbin \"" VECTORS "\"\nvectors_end:\n.previous\n");
extern const char vectors[], vectors_end[];

static uint64_t arena[1 << 17];
static size_t used;

void *allocate(size_t size)
{
    const size_t words = (size + 7) / 8, begin = used;
    if (!size || words > sizeof arena / 8 - used) fail("memory or size is rejected", "allocate");
    used += words;
    return arena + begin;
}

void fail(const char *what, const char *name)
{
    say(name), say(": "), say(what), say("\n");
    end(1);
}

void _start(void)
{
    end(replay_vectors(vectors, (size_t)(vectors_end - vectors)));
}
