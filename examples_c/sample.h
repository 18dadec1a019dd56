/* What the samples begin with: a call that fails ends the program, a body of one shape takes one line, and a step is one that
 * can be watched. Included before anything of the system's: it asks for a clock that C99 by itself does not have. */
#ifndef SAMPLE_H
#define SAMPLE_H

#ifndef _POSIX_C_SOURCE
#define _POSIX_C_SOURCE 199309L
#endif
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#ifndef CLOCK_MONOTONIC
#error "sample.h is to be included before the headers of the system"
#endif

#include "longspan/longspan.h"

static inline void check(LsResult result)
{
    if (result != LS_OK) {
        fprintf(stderr, "%s: %s\n", ls_result_name_get(result), ls_last_error_message_get());
        exit(1);
    }
}

static inline void expect(int holds, const char *what)
{
    if (!holds) {
        fprintf(stderr, "not so: %s\n", what);
        exit(1);
    }
}

static inline LsWorld create_world(void)
{
    LsWorldDef def;
    LsWorld world;
    check(ls_world_def_init(&def, sizeof def));
    check(ls_world_create(&def, &world));
    return world;
}

/* A body with one shape of default size (half a metre each way), by its LS_BODY_ and LS_SHAPE_ kind. */
static inline LsBody create_body(LsWorld world, int kind, int shape_kind, double x, double y)
{
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = shape_kind;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = kind;
    def.pose.position[0] = x;
    def.pose.position[1] = y;
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

/* Time of a clock that is never set (s). */
static inline double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static inline void wait_until(double moment)
{
    const double rest = moment - now();
    if (rest > 0.0) {
        struct timespec time;
        time.tv_sec = (time_t)rest;
        time.tv_nsec = (long)(1e9 * (rest - (double)time.tv_sec));
        nanosleep(&time, NULL);
    }
}

/* The header of a version from before there were streams has none of this. */
#ifdef LS_STREAM_FRAME
/* Publishes a world under a name with all that it has to show; with a library that has no streams the program ends here. */
static inline LsStream publish_world(LsWorld world, const char *name)
{
    LsStreamDef def;
    LsStream stream;
    double start;
    check(ls_stream_def_init(&def, sizeof def));
    def.name = name;
    def.layers = LS_STREAM_LAYER_ALL;
    check(ls_stream_open(world, &def, &stream));
    /* Whoever is waiting for it sees it from the first step on. */
    for (start = now(); now() < start + 0.5; wait_until(now() + 0.02))
        check(ls_stream_serve(stream));
    return stream;
}
#endif

/* A step. With LONGSPAN_STREAM=NAME in the environment, this and all that follow are published under that name, in real time, or,
 * with LONGSPAN_STREAM_SLOWER=N, N times slower. */
static inline void step_world(LsWorld world, float dt)
{
    static int is_watched = -1;
    static double due, slower = 1.0;
    if (is_watched < 0) {
#ifdef LS_STREAM_FRAME
        const char *name = getenv("LONGSPAN_STREAM"), *factor = getenv("LONGSPAN_STREAM_SLOWER");
        slower = factor != NULL ? atof(factor) : 1.0;
        is_watched = name != NULL && name[0] != 0;
        if (is_watched)
            publish_world(world, name);
#else
        is_watched = 0;
#endif
        due = now();
    }
    check(ls_world_step(world, dt));
    due += slower * dt;
    if (is_watched)
        wait_until(due);
}

#endif
