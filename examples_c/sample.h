/* What the samples begin with: a call that fails ends the program, and a body of one shape takes one line. */
#ifndef SAMPLE_H
#define SAMPLE_H

#include <stdio.h>
#include <stdlib.h>

#include "longspan/longspan.h"

static inline void check(LsResult result)
{
    if (result != LS_OK) {
        fprintf(stderr, "%s: %s\n", ls_result_name(result), ls_last_error_message());
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

#endif
