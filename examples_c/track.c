/* A tank track: 132 plates on hinges, driven over a step by two sprockets. Does it stay flat?
 *
 *     cc track.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o track && ./track
 *
 * ./track off leaves the plates to their hinges alone: chains of parallel hinges are then not kept in their plane. */

#include "sample.h"

#include <math.h>
#include <string.h>

#define TEETH 20
#define STRAIGHT 56
#define PLATES (2 * STRAIGHT + TEETH)
#define WHEELS 5
#define STEPS 1200
static const float DT = 1.0f / 60.0f;
static const float PI = 3.14159265f;
static const float PITCH = 0.1f;       /* from hinge to hinge (m) */
static const float HUB = 0.3f;         /* radius of wheels, and of sprockets between their teeth (m) */
static const float HALF_AXLES = 2.8f;  /* half the distance of the sprockets (m) */
static const float RATE = -4.0f;       /* of the sprockets (rad/s): forward is +x */

enum { GROUND = 1, PLATE = 2, WHEEL = 4 };

static void turn_about_z(float angle, float out[4])
{
    out[0] = out[1] = 0.0f;
    out[2] = sinf(0.5f * angle);
    out[3] = cosf(0.5f * angle);
}

static LsShapeDef create_shape(int kind, float friction, unsigned member_of, unsigned collides_with)
{
    LsShapeDef def;
    check(ls_shape_def_init(&def, sizeof def));
    def.kind = kind;
    def.material.friction = friction;
    def.filter.member_of = member_of;
    def.filter.collides_with = collides_with;
    return def;
}

static LsBody create_part(LsWorld world, int kind, const LsShapeDef *shape, float mass, double x, double y, float angle)
{
    LsBodyDef def;
    LsBody body;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = kind;
    def.pose.position[0] = x;
    def.pose.position[1] = y;
    turn_about_z(angle, def.pose.rotation);
    def.mass.kind = LS_MASS_TOTAL;
    def.mass.properties.mass = mass;
    def.shapes = shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

/* A hinge about z: the joint axis is the x axis of both frames. */
static void create_hinge(LsWorld world, LsBody a, float ax, LsBody b, float bx, float rate)
{
    const float x_to_z[4] = {0.0f, -0.70710678f, 0.0f, 0.70710678f};
    LsJointDef def;
    LsJoint joint;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_HINGE;
    def.body_a = a;
    def.body_b = b;
    def.frame_a.position[0] = ax;
    def.frame_b.position[0] = bx;
    memcpy(def.frame_a.rotation, x_to_z, sizeof x_to_z);
    memcpy(def.frame_b.rotation, x_to_z, sizeof x_to_z);
    if (rate != 0.0f) {
        def.motor.mode = LS_MOTOR_VELOCITY;
        def.motor.target = rate;
        def.motor.max_force = INFINITY;
    }
    check(ls_joint_create(world, &def, &joint));
}

static LsBody create_sprocket(LsWorld world, double x, double y)
{
    LsShapeDef parts[TEETH + 1], whole = create_shape(LS_SHAPE_COMPOUND, 0.3f, WHEEL, PLATE);
    int i;
    parts[0] = create_shape(LS_SHAPE_CYLINDER, 0.3f, WHEEL, PLATE);
    parts[0].half_height = 0.2f;
    parts[0].radius = HUB;
    parts[0].local_rotation[0] = parts[0].local_rotation[3] = 0.70710678f; /* its axis along z */
    for (i = 0; i < TEETH; ++i) {
        const float angle = 2.0f * PI * (float)i / TEETH;
        LsShapeDef *tooth = &parts[i + 1];
        *tooth = create_shape(LS_SHAPE_BOX, 0.3f, WHEEL, PLATE);
        tooth->half_extents[0] = 0.0225f;
        tooth->half_extents[1] = 0.01f;
        tooth->half_extents[2] = 0.2f;
        tooth->local_position[0] = 0.3125f * cosf(angle);
        tooth->local_position[1] = 0.3125f * sinf(angle);
        turn_about_z(angle, tooth->local_rotation);
    }
    whole.parts = parts;
    whole.part_count = TEETH + 1;
    return create_part(world, LS_BODY_DYNAMIC, &whole, 40.0f, x, y, 0.0f);
}

/* Hinge i of the track, in the plane of the wheels' axles. */
static void hinge_point(int i, double out[2])
{
    const double radius = 0.5 * PITCH / sin(PI / TEETH);
    const int half = PLATES / 2, other = i % PLATES >= half, k = i % half;
    const double angle = 0.5 * PI - 2.0 * PI * (k - STRAIGHT) / TEETH;
    const double x = k < STRAIGHT ? -HALF_AXLES + PITCH * k : HALF_AXLES + radius * cos(angle);
    const double y = k < STRAIGHT ? radius : radius * sin(angle);
    out[0] = other ? -x : x;
    out[1] = other ? -y : y;
}

static LsBody create_vehicle(LsWorld world, LsBody plates[PLATES])
{
    const double height = 0.5 * PITCH / sin(PI / TEETH) + 0.016;
    LsShapeDef shape = create_shape(LS_SHAPE_BOX, 0.5f, 8, 0);
    LsBody hull;
    int i;
    shape.half_extents[0] = 2.6f;
    shape.half_extents[1] = 0.1f;
    shape.half_extents[2] = 0.4f;
    hull = create_part(world, LS_BODY_DYNAMIC, &shape, 500.0f, 0.0, height, 0.0f);
    create_hinge(world, hull, -HALF_AXLES, create_sprocket(world, -HALF_AXLES, height), 0.0f, RATE);
    create_hinge(world, hull, HALF_AXLES, create_sprocket(world, HALF_AXLES, height), 0.0f, RATE);
    for (i = 1; i <= WHEELS; ++i) {
        const float x = -HALF_AXLES + HALF_AXLES / 3.0f * (float)i;
        LsShapeDef drum = create_shape(LS_SHAPE_CYLINDER, 0.3f, WHEEL, PLATE);
        drum.half_height = 0.2f;
        drum.radius = HUB;
        drum.local_rotation[0] = drum.local_rotation[3] = 0.70710678f;
        create_hinge(world, hull, x, create_part(world, LS_BODY_DYNAMIC, &drum, 20.0f, x, height, 0.0f), 0.0f, 0.0f);
    }
    shape = create_shape(LS_SHAPE_BOX, 0.8f, PLATE, GROUND | WHEEL);
    shape.half_extents[0] = 0.035f;
    shape.half_extents[1] = 0.015f;
    shape.half_extents[2] = 0.5f;
    for (i = 0; i < PLATES; ++i) {
        double from[2], to[2];
        hinge_point(i, from);
        hinge_point(i + 1, to);
        plates[i] = create_part(world, LS_BODY_DYNAMIC, &shape, 2.0f, 0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]) + height,
                                (float)atan2(to[1] - from[1], to[0] - from[0]));
    }
    for (i = 0; i < PLATES; ++i)
        create_hinge(world, plates[i], 0.5f * PITCH, plates[(i + 1) % PLATES], -0.5f * PITCH, 0.0f);
    return hull;
}

/* z of a world point in the frame of a pose. */
static double sideways(const LsPose *pose, const double point[3])
{
    const float *q = pose->rotation;
    const double normal[3] = {2.0 * (q[0] * q[2] + q[3] * q[1]), 2.0 * (q[1] * q[2] - q[3] * q[0]),
                              1.0 - 2.0 * (q[0] * q[0] + q[1] * q[1])};
    return (point[0] - pose->position[0]) * normal[0] + (point[1] - pose->position[1]) * normal[1]
           + (point[2] - pose->position[2]) * normal[2];
}

int main(int argc, char **argv)
{
    LsWorldDef def;
    LsLongRangeDef planes;
    LsWorld world;
    LsBody plates[PLATES], hull;
    LsPose at, plate;
    LsShapeDef ground = create_shape(LS_SHAPE_BOX, 0.8f, GROUND, PLATE);
    double worst = 0.0;
    int step, i;

    check(ls_world_def_init(&def, sizeof def));
    check(ls_world_create(&def, &world));
    check(ls_long_range_def_init(&planes, sizeof planes));
    if (argc > 1 && strcmp(argv[1], "off") == 0)
        planes.plane_position = planes.plane_axis = 0;
    check(ls_world_long_range_set(world, &planes));

    ground.half_extents[0] = 60.0f;
    ground.half_extents[2] = 5.0f;
    create_part(world, LS_BODY_STATIC, &ground, 1.0f, 0.0, -0.5, 0.0f);
    ground.half_extents[0] = 20.0f;
    ground.half_extents[1] = 0.075f;
    create_part(world, LS_BODY_STATIC, &ground, 1.0f, HALF_AXLES + 22.4, 0.075, 0.0f);
    hull = create_vehicle(world, plates);

    for (step = 0; step < STEPS; ++step) {
        step_world(world, DT);
        check(ls_body_pose_get(world, hull, &at));
        for (i = 0; i < PLATES; ++i) {
            check(ls_body_pose_get(world, plates[i], &plate));
            worst = fmax(worst, fabs(sideways(&at, plate.position)));
        }
    }
    printf("after %.0f s: %.1f m of way, plates at most %.1f mm beside the hull's plane\n", STEPS * DT, at.position[0], 1000.0 * worst);
    check(ls_world_destroy(world));
    return 0;
}
