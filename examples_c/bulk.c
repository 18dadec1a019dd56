/* A thousand bodies: two ways to read many poses at once.
 *
 *     cc bulk.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o bulk && ./bulk
 *
 * A renderer usually wants what moved (ls_world_moved_bodies_get): sleeping bodies cost nothing, and the user word finds the picture of
 * each body without a table. A host that wants certain bodies, moved or not, asks for them (ls_world_poses_get). */
#include "sample.h"

#include <string.h>

#define SIDE 10
#define BODIES (SIDE * SIDE * SIDE)

int main(void)
{
    static LsBody bodies[BODIES];
    static LsPose drawn[BODIES], poses[BODIES]; /* what a renderer would hold, and what the world says */
    LsWorldDef world_def;
    LsShapeDef shape;
    LsBodyDef def;
    LsWorld world;
    LsBody ground;
    size_t most = 0, least = BODIES, count, i;
    int step;

    check(ls_world_def_init(&world_def, sizeof world_def));
    world_def.body_capacity = BODIES + 1;
    check(ls_world_create(&world_def, &world));

    check(ls_shape_def_init(&shape, sizeof shape));
    check(ls_body_def_init(&def, sizeof def));
    def.shapes = &shape;
    def.shape_count = 1;
    shape.kind = LS_SHAPE_HALF_SPACE;
    def.kind = LS_BODY_STATIC;
    check(ls_body_create(world, &def, &ground));

    def.kind = LS_BODY_DYNAMIC;
    for (i = 0; i < BODIES; ++i) {
        shape.kind = i % 2 == 0 ? LS_SHAPE_BOX : LS_SHAPE_BALL;
        shape.radius = shape.half_extents[0] = shape.half_extents[1] = shape.half_extents[2] = 0.2f;
        def.pose.position[0] = (double)(i % SIDE);
        def.pose.position[1] = 0.5 + (double)(i / (SIDE * SIDE));
        def.pose.position[2] = (double)(i / SIDE % SIDE);
        def.user_word = i;
        drawn[i] = def.pose;
        check(ls_body_create(world, &def, &bodies[i]));
    }

    for (step = 0; step < 180; ++step) {
        const LsMoved *moved;
        check(ls_world_step(world, 1.0f / 60.0f));
        check(ls_world_moved_bodies_get(world, &moved, &count));
        for (i = 0; i < count; ++i) {
            drawn[moved[i].user_word] = moved[i].pose;
        }
        most = count > most ? count : most;
        least = count < least ? count : least;
    }

    check(ls_world_poses_get(world, bodies, BODIES, poses));
    for (i = 0; i < BODIES; ++i) {
        if (memcmp(&drawn[i], &poses[i], sizeof poses[i]) != 0) {
            fprintf(stderr, "body %lu is drawn where it is not\n", (unsigned long)i);
            return 1;
        }
    }
    check(ls_world_awake_body_count_get(world, &count));
    printf("%d bodies, %lu to %lu moved in a step, %lu awake at the end; all are drawn where they are\n", BODIES,
           (unsigned long)least, (unsigned long)most, (unsigned long)count);
    check(ls_world_destroy(world));
    return 0;
}
