/* A ring-shaped tower of stone blocks is hit by a ball of five tonnes: how many blocks are supported, through the collapse?
 *
 *     cc tower.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o tower && ./tower
 *
 * The tower of Mueller et al. 2017, Fig. 12, smaller: 10 courses of 40 blocks, each half a block round from the one below. */

#include "sample.h"

#include <math.h>

#define RING 40
#define COURSES 10
#define BLOCKS (RING * COURSES)
static const double RADIUS = 3.0;
static const float HALF[3] = {0.15f, 0.125f, 0.22f}; /* along the radius, up, along the ring (m) */

static LsBody create_block(LsWorld world, int index)
{
    const int course = index / RING, place = index % RING;
    const double angle = 2.0 * 3.14159265358979 * (place + 0.5 * (course % 2)) / RING;
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    int i;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    shape.density = 2000.0f;
    shape.material.friction = 0.6f;
    for (i = 0; i < 3; ++i) {
        shape.half_extents[i] = HALF[i];
    }
    check(ls_body_def_init(&def, sizeof def));
    def.kind = LS_BODY_DYNAMIC;
    def.pose.position[0] = RADIUS * cos(angle);
    def.pose.position[1] = HALF[1] * (1.0 + 2.0 * course);
    def.pose.position[2] = RADIUS * sin(angle);
    def.pose.rotation[1] = (float)sin(-angle / 2.0);
    def.pose.rotation[3] = (float)cos(angle / 2.0);
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

static void throw_ball(LsWorld world)
{
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BALL;
    shape.radius = 0.6f;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = LS_BODY_DYNAMIC;
    def.pose.position[0] = -8.0;
    def.pose.position[1] = 1.2;
    def.linear_velocity[0] = 20.0f;
    def.mass.kind = LS_MASS_TOTAL;
    def.mass.properties.mass = 5000.0f;
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
}

int main(void)
{
    LsWorldDef world_def;
    LsWorld world;
    LsShapeDef shape;
    LsBodyDef floor;
    LsBody ground;
    size_t supported = 0, standing = 0, fewest = BLOCKS;
    int i, step;

    check(ls_world_def_init(&world_def, sizeof world_def));
    world_def.support = 1;
    check(ls_world_create(&world_def, &world));
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    shape.half_extents[0] = shape.half_extents[2] = 50.0f;
    shape.half_extents[1] = 0.5f;
    check(ls_body_def_init(&floor, sizeof floor));
    floor.kind = LS_BODY_STATIC;
    floor.pose.position[1] = -0.5;
    floor.shapes = &shape;
    floor.shape_count = 1;
    check(ls_body_create(world, &floor, &ground));
    for (i = 0; i < BLOCKS; ++i) {
        create_block(world, i);
    }

    for (step = 0; step < 240; ++step) {
        if (step == 60) {
            check(ls_support_count_get(world, &standing));
            throw_ball(world);
        }
        step_world(world, 1.0f / 60.0f);
        check(ls_support_count_get(world, &supported));
        if (step >= 60 && supported < fewest) {
            fewest = supported;
        }
        if (step % 15 == 14) {
            printf("%.2f s: %u of %d blocks supported\n", (step + 1) / 60.0, (unsigned)supported, BLOCKS);
        }
    }
    expect(standing == BLOCKS, "a tower that stands is supported, every block of it");
    expect(fewest < BLOCKS, "what the ball throws about is not supported");
    expect(supported > fewest, "what comes to rest is supported again");
    check(ls_world_destroy(world));
    return 0;
}
