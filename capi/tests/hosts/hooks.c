/* The host's own memory, profiler and policy: what it gives is what the library takes, and all of it comes back. */
#define _POSIX_C_SOURCE 200809L
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "longspan/longspan.h"

static void expect(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "not so: %s (%s)\n", what, ls_last_error_message_get());
        exit(1);
    }
}

typedef struct Bank {
    size_t given, returned, blocks;
} Bank;

static void *give(size_t size, size_t alignment, void *user)
{
    Bank *bank = (Bank *)user;
    void *memory = NULL;
    if (posix_memalign(&memory, alignment < sizeof(void *) ? sizeof(void *) : alignment, size) != 0) {
        return NULL;
    }
    bank->given += size;
    ++bank->blocks;
    return memory;
}

static void take(void *memory, size_t size, size_t alignment, void *user)
{
    Bank *bank = (Bank *)user;
    (void)alignment;
    bank->returned += size;
    --bank->blocks;
    free(memory);
}

typedef struct Zones {
    int depth, deepest, begun;
    const char *stack[8];
    char seen[512];
} Zones;

static void begin(const char *name, void *user)
{
    Zones *zones = (Zones *)user;
    zones->stack[zones->depth++] = name;
    zones->deepest = zones->depth > zones->deepest ? zones->depth : zones->deepest;
    ++zones->begun;
    if (strstr(zones->seen, name) == NULL) {
        strcat(zones->seen, name);
        strcat(zones->seen, ";");
    }
}

static void end(const char *name, void *user)
{
    Zones *zones = (Zones *)user;
    expect(zones->depth > 0 && zones->stack[--zones->depth] == name, "zones end in the order in which they nest");
}

static LsWorld pile(Zones *zones)
{
    LsWorldDef world_def;
    LsShapeDef shape;
    LsBodyDef def;
    LsWorld world;
    LsBody body;
    int i;
    ls_world_def_init(&world_def, sizeof world_def);
    expect(ls_world_create(&world_def, &world) == LS_OK, "a world");
    expect(ls_world_profiler_set(world, begin, end, zones) == LS_OK, "a profiler");
    ls_shape_def_init(&shape, sizeof shape);
    ls_body_def_init(&def, sizeof def);
    def.shapes = &shape;
    def.shape_count = 1;
    def.can_sleep = 0;
    shape.kind = LS_SHAPE_HALF_SPACE;
    def.kind = LS_BODY_STATIC;
    expect(ls_body_create(world, &def, &body) == LS_OK, "ground");
    shape.kind = LS_SHAPE_BOX;
    def.kind = LS_BODY_DYNAMIC;
    for (i = 0; i < 20; ++i) {
        def.pose.position[0] = 1.5 * (i % 5);
        def.pose.position[1] = 0.5 + i / 5;
        expect(ls_body_create(world, &def, &body) == LS_OK, "a box");
    }
    return world;
}

/* The signal that ends a child which makes a mistake under this policy; 0 if it lives on. */
static int fate(int32_t level)
{
    int status = 0;
    pid_t child;
    fflush(NULL);
    child = fork();
    if (child == 0) {
        const LsWorld none = {0};
        ls_abort_level_set(level);
        _exit(ls_world_step(none, 1.0f) == LS_ERROR_NULL_HANDLE ? 0 : 2);
    }
    expect(child > 0 && waitpid(child, &status, 0) == child, "a child");
    return WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
}

int main(void)
{
    Bank bank = {0, 0, 0};
    LsAllocator allocator = {give, take, NULL}, none = {NULL, take, NULL};
    LsMemory before, after;
    Zones zones;
    LsWorld world;
    int step;

    memset(&zones, 0, sizeof zones);
    allocator.user = &bank;
    expect(ls_allocator_set(&none) == LS_ERROR_NULL_ARGUMENT, "an allocator that gives nothing is refused");
    expect(ls_allocator_set(&allocator) == LS_OK, "the first call sets the allocator");
    world = pile(&zones);
    for (step = 0; step < 200; ++step) {
        expect(ls_world_step(world, 1.0f / 60.0f) == LS_OK, "a step");
    }
    expect(ls_memory_get(&before, sizeof before) == LS_OK, "memory");
    expect(before.bytes > 10000 && before.bytes == bank.given - bank.returned && before.blocks == bank.blocks,
           "what the library counts is what the host gave");
    expect(ls_allocator_set(NULL) == LS_ERROR_NOT_APPLICABLE, "too late for another allocator");
    for (step = 0; step < 100; ++step) {
        expect(ls_world_step(world, 1.0f / 60.0f) == LS_OK, "a step");
    }
    expect(ls_memory_get(&after, sizeof after) == LS_OK && after.allocations == before.allocations,
           "a steady step allocates nothing");
    printf("%lu bytes in %lu blocks, 0 allocations in 100 steps\n", (unsigned long)after.bytes, (unsigned long)after.blocks);
    expect(zones.depth == 0 && zones.deepest == 2 && zones.begun == 300 * 8, "a step is a zone with seven inside");
    printf("%s\n", zones.seen);
    expect(ls_world_destroy(world) == LS_OK, "the end");
    expect(ls_memory_get(&after, sizeof after) == LS_OK && after.bytes < 1000 && after.peak_bytes >= before.bytes,
           "a world leaves next to nothing behind");

    expect(fate(LS_LOG_OFF) == 0 && fate(LS_LOG_ERROR) == 0, "a refused call is no reason to end");
    expect(fate(LS_LOG_WARNING) == SIGABRT, "unless the host says so");
    return 0;
}
