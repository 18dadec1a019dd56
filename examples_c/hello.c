/* A box falls on the ground. Prints its pose every ten steps.
 *
 *     cc hello.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o hello && ./hello */
#include <stdio.h>
#include <stdlib.h>

#include "longspan/longspan.h"

static void check(LsResult result)
{
    if (result != LS_OK) {
        fprintf(stderr, "%s: %s\n", ls_result_name_get(result), ls_last_error_message_get());
        exit(1);
    }
}

int main(void)
{
    LsWorldDef world_def;
    LsShapeDef ground_shape, box_shape;
    LsBodyDef ground_def, box_def;
    LsWorld world;
    LsBody ground, box;
    int step;

    check(ls_world_def_init(&world_def, sizeof world_def));
    check(ls_world_create(&world_def, &world));

    check(ls_shape_def_init(&ground_shape, sizeof ground_shape));
    ground_shape.kind = LS_SHAPE_HALF_SPACE; /* its normal is +y unless changed */
    check(ls_body_def_init(&ground_def, sizeof ground_def));
    ground_def.kind = LS_BODY_STATIC;
    ground_def.shapes = &ground_shape;
    ground_def.shape_count = 1;
    check(ls_body_create(world, &ground_def, &ground));

    check(ls_shape_def_init(&box_shape, sizeof box_shape));
    box_shape.kind = LS_SHAPE_BOX; /* edges of 1 m unless changed */
    check(ls_body_def_init(&box_def, sizeof box_def));
    box_def.pose.position[1] = 3.0;
    box_def.shapes = &box_shape;
    box_def.shape_count = 1;
    check(ls_body_create(world, &box_def, &box));

    for (step = 1; step <= 120; ++step) {
        check(ls_world_step(world, 1.0f / 60.0f));
        if (step % 10 == 0) {
            LsPose pose;
            check(ls_body_pose_get(world, box, &pose));
            printf("%4.2f s  position %7.4f %7.4f %7.4f  rotation %7.4f %7.4f %7.4f %7.4f\n", step / 60.0, pose.position[0],
                   pose.position[1], pose.position[2], pose.rotation[0], pose.rotation[1], pose.rotation[2], pose.rotation[3]);
        }
    }
    check(ls_world_destroy(world));
    return 0;
}
