#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "game.h"

#define PLANKS 24
#define ROPE_LINKS 12
#define TOWER_LEVELS 14
#define WALL_COLUMNS 9
#define WALL_ROWS 7

void check(LsResult result)
{
    if (result != LS_OK) {
        fprintf(stderr, "%s: %s\n", ls_result_name_get(result), ls_last_error_message_get());
        exit(1);
    }
}

typedef struct Part {
    int kind;
    Look look;
    int is_ball;
    float half[3];
    double at[3];
    float mass; /* kg; 0 for that of its volume */
} Part;

static Thing *add(Game *game, const Part *part)
{
    Thing *thing = &game->things[game->count];
    LsShapeDef shape;
    LsBodyDef def;
    if (game->count == MAX_THINGS) {
        fprintf(stderr, "the game is full\n");
        exit(1);
    }
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = part->is_ball ? LS_SHAPE_BALL : LS_SHAPE_BOX;
    shape.radius = part->half[0];
    memcpy(shape.half_extents, part->half, sizeof shape.half_extents);
    shape.material.friction = 0.6f;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = part->kind;
    memcpy(def.pose.position, part->at, sizeof part->at);
    def.shapes = &shape;
    def.shape_count = 1;
    def.user_word = ++game->count;
    if (part->mass > 0.0f) {
        def.mass.kind = LS_MASS_TOTAL;
        def.mass.properties.mass = part->mass;
    }
    thing->look = part->look;
    thing->is_ball = part->is_ball;
    memcpy(thing->half, part->half, sizeof thing->half);
    thing->before = thing->now = def.pose;
    check(ls_body_create(game->world, &def, &thing->body));
    return thing;
}

/* A joint of two things at a point of the world; its axis is world axis 0, 1 or 2. */
static LsJoint join(Game *game, const Thing *a, const Thing *b, const double at[3], int kind, int axis, LsJointDef *def)
{
    static const float turns[3][4] = {{0, 0, 0, 1}, {0, 0, 0.70710678f, 0.70710678f}, {0, -0.70710678f, 0, 0.70710678f}};
    LsJoint joint;
    int i;
    def->kind = kind;
    def->body_a = a->body;
    def->body_b = b->body;
    for (i = 0; i < 3; ++i) {
        def->frame_a.position[i] = at[i] - a->now.position[i];
        def->frame_b.position[i] = at[i] - b->now.position[i];
    }
    memcpy(def->frame_a.rotation, turns[axis], sizeof turns[axis]);
    memcpy(def->frame_b.rotation, turns[axis], sizeof turns[axis]);
    check(ls_joint_create(game->world, def, &joint));
    return joint;
}

static void build_bridge(Game *game)
{
    const float half = 0.25f;
    const double height = 3.0, length = 2.0 * half * PLANKS, left = -14.0;
    Thing *last = add(game, &(Part){LS_BODY_STATIC, LOOK_GROUND, 0, {1, 1.5f, 1.5f}, {left - 1, 1.5, 0}, 0});
    LsJointDef def;
    int i;
    check(ls_joint_def_init(&def, sizeof def));
    for (i = 0; i <= PLANKS; ++i) {
        const double edge = left + 2.0 * half * i;
        const double at[3] = {edge, height - 0.1, 0};
        Thing *next = i < PLANKS
                          ? add(game, &(Part){LS_BODY_DYNAMIC, LOOK_BRIDGE, 0, {half, 0.08f, 1.2f}, {edge + half, height - 0.1, 0}, 20})
                          : add(game, &(Part){LS_BODY_STATIC, LOOK_GROUND, 0, {1, 1.5f, 1.5f}, {left + length + 1, 1.5, 0}, 0});
        join(game, last, next, at, LS_JOINT_HINGE, 2, &def);
        last = next;
    }
}

static void build_crane(Game *game)
{
    const double x = 4.0, height = 9.0, arm = 5.0, link = 0.4;
    Thing *mast = add(game, &(Part){LS_BODY_STATIC, LOOK_CRANE, 0, {0.3f, 4.4f, 0.3f}, {x, 4.4, -3}, 0});
    Thing *last = add(game, &(Part){LS_BODY_DYNAMIC, LOOK_CRANE, 0, {3.5f, 0.2f, 0.2f}, {x + 1.5, height, -3}, 4000});
    LsJointDef def;
    int i;
    double at[3];
    check(ls_joint_def_init(&def, sizeof def));
    at[0] = x;
    at[1] = height - 0.2;
    at[2] = -3;
    def.motor.mode = LS_MOTOR_VELOCITY;
    def.motor.target = 0.0f;
    def.motor.max_force = 2e5f;
    game->slew = join(game, mast, last, at, LS_JOINT_HINGE, 1, &def);
    /* A rope of links of one kilogram carries a ball of three tonnes. */
    check(ls_joint_def_init(&def, sizeof def));
    at[0] = x + arm;
    for (i = 0; i <= ROPE_LINKS; ++i) {
        Thing *next;
        at[1] = height - 0.2 - link * i;
        next = i < ROPE_LINKS
                   ? add(game, &(Part){LS_BODY_DYNAMIC, LOOK_ROPE, 0, {0.05f, (float)link * 0.5f, 0.05f}, {at[0], at[1] - link * 0.5, -3}, 1})
                   : add(game, &(Part){LS_BODY_DYNAMIC, LOOK_BALL, 1, {0.6f, 0.6f, 0.6f}, {at[0], at[1] - 0.6, -3}, 3000});
        join(game, last, next, at, LS_JOINT_SPHERICAL, 0, &def);
        last = next;
    }
}

static void build_tower(Game *game)
{
    int level, side;
    for (level = 0; level < TOWER_LEVELS; ++level) {
        for (side = 0; side < 3; ++side) {
            const double off = 0.5 * (side - 1), y = 0.2 + 0.4 * level;
            const int crosswise = level % 2;
            add(game, &(Part){LS_BODY_DYNAMIC, LOOK_TOWER, 0, {crosswise ? 0.75f : 0.24f, 0.2f, crosswise ? 0.24f : 0.75f},
                              {13.0 + (crosswise ? 0.0 : off), y, crosswise ? off : 0.0}, 0});
        }
    }
}

/* Bricks held together by joints that break. */
static void build_wall(Game *game)
{
    const float half[3] = {0.3f, 0.25f, 0.25f};
    Thing *bricks[WALL_ROWS][WALL_COLUMNS];
    LsJointDef def;
    int row, column;
    check(ls_joint_def_init(&def, sizeof def));
    def.break_force = 9000.0f;
    def.break_torque = 3000.0f;
    for (row = 0; row < WALL_ROWS; ++row) {
        for (column = 0; column < WALL_COLUMNS; ++column) {
            const double x = 2.0 + 2 * half[0] * column, y = half[1] * (1 + 2 * row);
            const double beside[3] = {x - half[0], y, 4.0}, below[3] = {x, y - half[1], 4.0};
            bricks[row][column] = add(game, &(Part){LS_BODY_DYNAMIC, LOOK_WALL, 0, {half[0], half[1], half[2]}, {x, y, 4.0}, 0});
            if (column > 0) {
                join(game, bricks[row][column - 1], bricks[row][column], beside, LS_JOINT_FIXED, 0, &def);
            }
            if (row > 0) {
                join(game, bricks[row - 1][column], bricks[row][column], below, LS_JOINT_FIXED, 0, &def);
            }
        }
    }
}

void scene_build(Game *game)
{
    LsWorldDef def;
    LsBodyDef hand;
    check(ls_world_def_init(&def, sizeof def));
    check(ls_world_create(&def, &game->world));
    add(game, &(Part){LS_BODY_STATIC, LOOK_GROUND, 0, {40, 0.5f, 40}, {0, -0.5, 0}, 0});
    build_bridge(game);
    build_crane(game);
    build_tower(game);
    build_wall(game);
    check(ls_body_def_init(&hand, sizeof hand));
    hand.kind = LS_BODY_KINEMATIC;
    check(ls_body_create(game->world, &hand, &game->hand));

    if (ls_world_save(game->world, NULL, 0, &game->start_size) != LS_ERROR_BUFFER_TOO_SMALL) {
        exit(1);
    }
    game->start = malloc(game->start_size);
    check(ls_world_save(game->world, game->start, game->start_size, &game->start_size));
    game->start_count = game->count;
}

void scene_reset(Game *game)
{
    size_t i;
    game->grip.id = 0;
    check(ls_world_restore(game->world, game->start, game->start_size));
    game->count = game->start_count;
    game->bricks_broken = 0;
    for (i = 0; i < game->count; ++i) {
        check(ls_body_pose_get(game->world, game->things[i].body, &game->things[i].now));
        game->things[i].before = game->things[i].now;
    }
}

void scene_shoot(Game *game, const double from[3], const double towards[3], float speed)
{
    Thing *ball = add(game, &(Part){LS_BODY_DYNAMIC, LOOK_BALL, 1, {0.35f, 0.35f, 0.35f}, {from[0], from[1], from[2]}, 250});
    double way[3], length = 0.0;
    float velocity[3];
    int i;
    for (i = 0; i < 3; ++i) {
        way[i] = towards[i] - from[i];
        length += way[i] * way[i];
    }
    for (i = 0; i < 3; ++i) {
        velocity[i] = (float)(way[i] / sqrt(length) * speed);
    }
    check(ls_body_linear_velocity_set(game->world, ball->body, velocity));
    check(ls_body_fast_set(game->world, ball->body, 1));
}

void scene_step(Game *game)
{
    const LsMoved *moved;
    const LsJointOverload *overloaded;
    LsJointDef slew;
    size_t count, i;
    check(ls_joint_def_get(game->world, game->slew, &slew, sizeof slew));
    if (slew.motor.target != game->slew_speed) {
        slew.motor.target = game->slew_speed;
        check(ls_joint_kind_set(game->world, game->slew, &slew));
    }
    for (i = 0; i < game->count; ++i) {
        game->things[i].before = game->things[i].now;
    }
    check(ls_world_step(game->world, STEP));
    check(ls_world_moved_bodies_get(game->world, &moved, &count));
    for (i = 0; i < count; ++i) {
        if (moved[i].user_word > 0 && moved[i].user_word <= game->count) {
            game->things[moved[i].user_word - 1].now = moved[i].pose;
        }
    }
    /* Mortar gives way. */
    check(ls_world_overloaded_joints_get(game->world, &overloaded, &count));
    for (i = 0; i < count; ++i) {
        if (ls_joint_destroy(game->world, overloaded[i].joint) == LS_OK) {
            ++game->bricks_broken;
        }
    }
}
