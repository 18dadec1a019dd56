/* A step whose parts are done by a pool of threads of the host, by the host inline, and by the library: the same bits.
 * Prints a line for each way: its name, the hash after each of three stretches, and how many jobs and parts the host did. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "longspan/longspan.h"

#define BODIES 700
#define MAX_THREADS 4

static void check(LsResult result)
{
    if (result != LS_OK) {
        fprintf(stderr, "%s: %s\n", ls_result_name_get(result), ls_last_error_message_get());
        exit(1);
    }
}

/* The smallest job system there is: it starts its threads for each job, and each takes the next range until none is left. */
typedef struct {
    int threads;
    size_t grain;
    long jobs, parts;
    pthread_mutex_t lock;
    size_t next, count;
    LsJobFunction run;
    void *job;
} Pool;

static void *work(void *user)
{
    Pool *pool = (Pool *)user;
    for (;;) {
        size_t begin, end;
        pthread_mutex_lock(&pool->lock);
        begin = pool->next;
        end = begin + pool->grain < pool->count ? begin + pool->grain : pool->count;
        pool->next = end;
        pthread_mutex_unlock(&pool->lock);
        if (begin == end) {
            return NULL;
        }
        pool->run(pool->job, begin, end);
    }
}

static void on_threads(size_t count, LsJobFunction run, void *job, void *user)
{
    Pool *pool = (Pool *)user;
    pthread_t threads[MAX_THREADS];
    int i;
    pool->next = 0;
    pool->count = count;
    pool->run = run;
    pool->job = job;
    ++pool->jobs;
    pool->parts += (long)count;
    for (i = 1; i < pool->threads; ++i) {
        pthread_create(&threads[i], NULL, work, pool);
    }
    work(pool);
    for (i = 1; i < pool->threads; ++i) {
        pthread_join(threads[i], NULL);
    }
}

static void inline_jobs(size_t count, LsJobFunction run, void *job, void *user)
{
    Pool *pool = (Pool *)user;
    ++pool->jobs;
    pool->parts += (long)count;
    run(job, 0, count);
}

/* Does nothing at all: what a host leaves out, the library does. */
static void idle(size_t count, LsJobFunction run, void *job, void *user)
{
    (void)count, (void)run, (void)job;
    ++((Pool *)user)->jobs;
}

static LsWorld create_world(uint32_t threads)
{
    LsWorldDef def;
    LsShapeDef shape;
    LsBodyDef body_def;
    LsWorld world;
    LsBody body;
    int i;
    check(ls_world_def_init(&def, sizeof def));
    def.threads = threads;
    check(ls_world_create(&def, &world));
    check(ls_shape_def_init(&shape, sizeof shape));
    check(ls_body_def_init(&body_def, sizeof body_def));
    body_def.shapes = &shape;
    body_def.shape_count = 1;
    shape.kind = LS_SHAPE_HALF_SPACE;
    body_def.kind = LS_BODY_STATIC;
    check(ls_body_create(world, &body_def, &body));
    body_def.kind = LS_BODY_DYNAMIC;
    for (i = 0; i < BODIES; ++i) {
        shape.kind = i % 3 ? LS_SHAPE_BOX : LS_SHAPE_BALL;
        body_def.pose.position[0] = 1.05 * (i % 8) + 0.01 * (i % 5);
        body_def.pose.position[1] = 0.6 + 1.02 * (i / 64);
        body_def.pose.position[2] = 1.05 * (i / 8 % 8);
        check(ls_body_create(world, &body_def, &body));
    }
    return world;
}

static void run(const char *name, uint32_t threads, LsParallelForCallback callback, Pool *pool)
{
    LsWorld world = create_world(threads);
    uint64_t hash;
    int stretch, step;
    check(ls_world_parallel_for_set(world, callback, pool));
    printf("%s", name);
    for (stretch = 0; stretch < 3; ++stretch) {
        for (step = 0; step < 20; ++step) {
            check(ls_world_step(world, 1.0f / 60.0f));
        }
        check(ls_world_state_hash_get(world, &hash));
        printf(" %016llx", (unsigned long long)hash);
    }
    printf(" %ld %ld\n", pool->jobs, pool->parts);
    check(ls_world_destroy(world));
}

int main(void)
{
    Pool pool = {1, 1, 0, 0, PTHREAD_MUTEX_INITIALIZER, 0, 0, NULL, NULL};
    run("library-1", 1, NULL, &pool);
    run("library-4", 4, NULL, &pool);
    for (pool.threads = 1; pool.threads <= MAX_THREADS; pool.threads *= 2) {
        char name[32];
        pool.grain = (size_t)pool.threads;
        pool.jobs = pool.parts = 0;
        sprintf(name, "host-%d", pool.threads);
        run(name, 1, on_threads, &pool);
    }
    pool.jobs = pool.parts = 0;
    run("inline", 4, inline_jobs, &pool);
    pool.jobs = pool.parts = 0;
    run("idle", 1, idle, &pool);
    return 0;
}
