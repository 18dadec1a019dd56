/* What a step tells: who hit whom and how hard, who is in a trigger, which joint came to its stop. By callback, and as arrays.
 *
 *     cc events.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o events && ./events
 *
 * A ball of one kilogram falls through a trigger onto a floor, and a door swings shut. */
#include "sample.h"

#include <math.h>

typedef struct Seen {
    int entered, left, hits, stops, began;
    float speed, impulse;
    LsBody ball;
} Seen;

static void on_entered(LsWorld world, const LsContactPair *pairs, size_t count, void *user)
{
    Seen *seen = (Seen *)user;
    expect(count == 1 && pairs[0].body_b.id == seen->ball.id, "the sensor comes first, what it sees second");
    expect(ls_body_destroy(world, seen->ball) == LS_ERROR_WORLD_LOCKED, "a callback looks and does not touch");
    ++seen->entered;
}

static void on_left(LsWorld world, const LsContactPair *pairs, size_t count, void *user)
{
    (void)world;
    (void)pairs;
    ((Seen *)user)->left += (int)count;
}

static void on_began(LsWorld world, const LsContactPair *pairs, size_t count, void *user)
{
    (void)world;
    (void)pairs;
    ((Seen *)user)->began += (int)count;
}

static void on_hits(LsWorld world, const LsHit *hits, size_t count, void *user)
{
    Seen *seen = (Seen *)user;
    const LsHit *same;
    size_t same_count;
    check(ls_world_hits_get(world, &same, &same_count));
    expect(same == hits && same_count == count, "the array is the same");
    if (seen->hits++ == 0) {
        seen->speed = hits[0].approach_speed;
        seen->impulse = hits[0].impulse;
        expect(fabs(hits[0].point[1]) < 0.05, "it hits the floor");
    }
}

static void on_stops(LsWorld world, const LsJointStop *stops, size_t count, void *user)
{
    (void)world;
    expect(count == 1 && stops[0].upper == 1 && stops[0].axis == 0 && stops[0].user_word == 77, "the door's upper stop");
    ++((Seen *)user)->stops;
}

static void hang_door(LsWorld world)
{
    LsBody door = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 10.5, 3.0);
    LsJointDef def;
    LsJoint joint;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_HINGE;
    def.body_b = door;
    def.frame_a.position[0] = 10.0;
    def.frame_a.position[1] = 3.0;
    def.frame_b.position[0] = -0.5;
    /* The joint axis is x of the frames: turned to point upwards. */
    def.frame_a.rotation[2] = def.frame_b.rotation[2] = 0.70710678f;
    def.frame_a.rotation[3] = def.frame_b.rotation[3] = 0.70710678f;
    def.limits.min = -0.5f;
    def.limits.max = 0.5f;
    /* It is driven against its stop, and presses on it from then on. */
    def.motor.mode = LS_MOTOR_VELOCITY;
    def.motor.target = 1.0f;
    def.motor.max_force = 1000.0f;
    def.user_word = 77;
    check(ls_joint_create(world, &def, &joint));
}

int main(void)
{
    LsWorld world = create_world();
    LsShapeDef trigger;
    LsBodyDef def;
    LsBody zone;
    LsMass mass = {LS_MASS_TOTAL, {1, {0, 0, 0}, {0, 0, 0}, {0, 0, 0, 1}}};
    LsCallbacks callbacks;
    const LsContactPair *inside;
    Seen seen = {0, 0, 0, 0, 0, 0, 0, {0}};
    LsRay ray = {{0, 3, -9}, {0, 0, 1}, 20};
    LsRayHit hit;
    size_t count;
    int step, was_inside = 0;

    check(ls_world_hit_threshold_set(world, 2.0f));
    create_body(world, LS_BODY_STATIC, LS_SHAPE_HALF_SPACE, 0, 0);
    seen.ball = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BALL, 0, 6);
    check(ls_body_mass_set(world, seen.ball, &mass));
    hang_door(world);

    check(ls_shape_def_init(&trigger, sizeof trigger));
    trigger.kind = LS_SHAPE_BOX;
    trigger.sensor = 1;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = LS_BODY_STATIC;
    def.pose.position[1] = 3;
    def.shapes = &trigger;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &zone));
    check(ls_world_ray_cast(world, &ray, NULL, &hit));
    expect(hit.shape.id == 0, "a ray passes through a sensor");

    check(ls_callbacks_init(&callbacks, sizeof callbacks));
    callbacks.user = &seen;
    callbacks.sensor_began = on_entered;
    callbacks.sensor_ended = on_left;
    callbacks.contact_began = on_began;
    callbacks.hits = on_hits;
    callbacks.joint_stops = on_stops;
    check(ls_world_callbacks_set(world, &callbacks));

    for (step = 0; step < 120; ++step) {
        check(ls_world_step(world, 1.0f / 60.0f));
        check(ls_world_sensor_overlaps_get(world, &inside, &count));
        was_inside += count == 1;
    }
    printf("the ball was in the trigger for %d steps: entered %d, left %d\n", was_inside, seen.entered, seen.left);
    expect(seen.entered == 1 && seen.left == 1 && was_inside > 5, "it fell through");
    printf("it hit the floor at %.2f m/s with %.2f N s\n", seen.speed, seen.impulse);
    /* From 5.5 m: sqrt(2 g h); one kilogram stopped, so the impulse is the speed. */
    expect(fabsf(seen.speed - 10.39f) < 0.2f && fabsf(seen.impulse - 10.39f) < 0.5f && seen.hits >= 1, "as hard as it fell");
    printf("the door came to its stop %d time(s)\n", seen.stops);
    expect(seen.stops >= 1 && seen.began >= 1, "the door");

    /* In mid-air a body can become part of the scenery, and come back to life. */
    check(ls_body_kind_set(world, seen.ball, LS_BODY_STATIC));
    check(ls_body_destroy(world, zone));
    check(ls_world_step(world, 1.0f / 60.0f));
    expect(ls_body_kind_set(world, seen.ball, 9) == LS_ERROR_INVALID_ENUM, "a kind that is none");
    check(ls_body_kind_set(world, seen.ball, LS_BODY_DYNAMIC));
    check(ls_world_step(world, 1.0f / 60.0f));
    check(ls_world_destroy(world));
    return 0;
}
