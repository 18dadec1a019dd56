/* A crossbow that a soft bound draws straight: the limbs are modelled bent, their hinges stop where a limb is straight, and the
 * greatest distance that this leaves between the two ends of a limb, taken as a spring's length, shoots the arrow. How fast?
 *
 *     cc crossbow.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o crossbow && ./crossbow
 *
 * After Mueller et al. 2017, Fig. 16. Seen from above: limbs along z, the arrow along x, no gravity. */
#include "sample.h"

#include <math.h>
#include <string.h>

#define LINKS 8
#define RODS 10
#define SIDES 2
#define STEPS 60
static const float DT = 1.0f / 60.0f;
static const double LINK = 0.1, BEND = 9.0 * 3.14159265358979 / 180.0, STRING = 0.75, RISER = 0.05, BLOCK = 0.02, ARROW = 0.3;

/* A box along a direction in the plane of x and z that touches only what belongs to `group`. */
static LsBody create_box(LsWorld world, float mass, const double half[3], double x, double z, double dx, double dz, uint32_t group)
{
    const double angle = atan2(-dz, dx);
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    int i;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    shape.material.friction = 0.0f;
    shape.filter.member_of = shape.filter.collides_with = group;
    for (i = 0; i < 3; ++i) {
        shape.half_extents[i] = (float)half[i];
    }
    check(ls_body_def_init(&def, sizeof def));
    def.kind = mass > 0.0f ? LS_BODY_DYNAMIC : LS_BODY_STATIC;
    def.mass.kind = mass > 0.0f ? LS_MASS_TOTAL : LS_MASS_FROM_SHAPES;
    def.mass.properties.mass = mass;
    def.pose.position[0] = x;
    def.pose.position[2] = z;
    def.pose.rotation[1] = (float)sin(angle / 2.0);
    def.pose.rotation[3] = (float)cos(angle / 2.0);
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

/* The point of a body's frame that is at x, z in the world now, and the frame there that looks along the world's axes, turned so
 * that its x axis is up (side 1) or down (side -1). */
static LsPose frame_at(LsWorld world, LsBody body, double x, double z, int side)
{
    /* Up is y: a quarter turn about z takes x there. */
    const float s = (float)(side * sqrt(0.5)), c = (float)sqrt(0.5);
    LsPose pose, frame;
    double dx, dz, sine, cosine;
    memset(&frame, 0, sizeof frame);
    check(ls_body_pose_get(world, body, &pose));
    dx = x - pose.position[0];
    dz = z - pose.position[2];
    sine = 2.0 * pose.rotation[1] * pose.rotation[3];
    cosine = 1.0 - 2.0 * pose.rotation[1] * pose.rotation[1];
    frame.position[0] = cosine * dx - sine * dz;
    frame.position[2] = sine * dx + cosine * dz;
    /* The inverse of the body's turn about y, then the quarter turn. */
    frame.rotation[0] = -pose.rotation[1] * s;
    frame.rotation[1] = -pose.rotation[1] * c;
    frame.rotation[2] = pose.rotation[3] * s;
    frame.rotation[3] = pose.rotation[3] * c;
    return frame;
}

static LsJoint tie(LsWorld world, int kind, LsBody a, LsBody b, double x, double z, int side)
{
    LsJointDef def;
    LsJoint joint;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = kind;
    def.body_a = a;
    def.body_b = b;
    def.frame_a = frame_at(world, a, x, z, side);
    def.frame_b = frame_at(world, b, x, z, side);
    if (kind == LS_JOINT_HINGE) {
        /* From the bend that it has now to straight. */
        def.limits.min = 0.0f;
        def.limits.max = (float)BEND;
    }
    check(ls_joint_create(world, &def, &joint));
    return joint;
}

/* Speed of the arrow, the worst that a hinge passes its stops by (rad), and the worst that a bound is passed by (m). */
typedef struct {
    float speed, overshoot, passed;
} Shot;

static Shot shoot(float stiffness)
{
    const double riser_half[3] = {RISER, 0.02, RISER}, limb_half[3] = {0.05, 0.015, 0.01}, block_half[3] = {BLOCK, BLOCK, BLOCK};
    const double arrow_half[3] = {ARROW, 0.01, 0.01};
    LsWorld world;
    LsWorldDef world_def;
    LsLongRangeDef derived;
    LsBody riser, block, arrow, limbs[SIDES];
    LsJoint feet[SIDES], hinges[SIDES * LINKS];
    LsBound bounds[256];
    float velocity[3];
    Shot shot = {0.0f, 0.0f, 0.0f};
    double tip_x = 0.0, tip_z = 0.0, back;
    size_t count, n;
    int side, i, step;

    check(ls_world_def_init(&world_def, sizeof world_def));
    world_def.gravity[1] = 0.0f;
    world_def.solver = LS_SOLVER_GAUSS_SEIDEL;
    world_def.substeps = 16;
    check(ls_world_create(&world_def, &world));
    check(ls_long_range_def_init(&derived, sizeof derived));
    check(ls_world_long_range_set(world, &derived));

    riser = create_box(world, 0.0f, riser_half, 0.0, 0.0, 1.0, 0.0, 0);
    for (side = 0; side < SIDES; ++side) {
        const int sign = side ? 1 : -1;
        LsBody held = riser;
        double x = 0.0, z = sign * RISER;
        for (i = 0; i < LINKS; ++i) {
            const double bend = BEND * (i + 1), dx = -sin(bend), dz = sign * cos(bend);
            const LsBody link = create_box(world, 0.3f, limb_half, x + 0.5 * LINK * dx, z + 0.5 * LINK * dz, dx, dz, 0);
            hinges[side * LINKS + i] = tie(world, LS_JOINT_HINGE, held, link, x, z, sign);
            if (i == 0) {
                feet[side] = hinges[side * LINKS];
            }
            held = link;
            x += LINK * dx;
            z += LINK * dz;
        }
        limbs[side] = held;
        tip_x = x;
        tip_z = z;
    }
    back = tip_x - sqrt(STRING * STRING - (tip_z - BLOCK) * (tip_z - BLOCK));
    block = create_box(world, 0.05f, block_half, back, 0.0, 1.0, 0.0, 2);
    for (side = 0; side < SIDES; ++side) {
        const int sign = side ? 1 : -1;
        const double from[2] = {tip_x, sign * tip_z}, to[2] = {back, sign * BLOCK};
        const double dx = (to[0] - from[0]) / RODS, dz = (to[1] - from[1]) / RODS;
        const double rod_half[3] = {0.5 * hypot(dx, dz), 0.01, 0.01};
        LsBody held = limbs[side];
        LsSoftBound spring;
        for (i = 0; i < RODS; ++i) {
            const double x = from[0] + i * dx, z = from[1] + i * dz;
            const LsBody rod = create_box(world, 0.05f, rod_half, x + 0.5 * dx, z + 0.5 * dz, dx, dz, 0);
            const LsJoint joint = tie(world, LS_JOINT_SPHERICAL, held, rod, x, z, 1);
            if (i == 0) {
                /* From the limb's foot to its tip. */
                spring.share = 1.0f;
                spring.softness.compliance = 1.0f / stiffness;
                spring.softness.damping = 0.0f;
                check(ls_world_soft_bound_set(world, feet[side], joint, &spring));
            }
            held = rod;
        }
        tie(world, LS_JOINT_SPHERICAL, held, block, to[0], to[1], 1);
    }
    arrow = create_box(world, 0.2f, arrow_half, back + BLOCK + 0.001 + ARROW, 0.0, 1.0, 0.0, 2);

    for (step = 0; step < STEPS; ++step) {
        step_world(world, DT);
        for (i = 0; i < SIDES * LINKS; ++i) {
            LsJointState hinge;
            check(ls_joint_state_get(world, hinges[i], &hinge, sizeof hinge));
            shot.overshoot = fmaxf(shot.overshoot, fmaxf(-hinge.position, hinge.position - (float)BEND));
        }
        check(ls_world_bounds_get(world, bounds, sizeof bounds / sizeof bounds[0], &count));
        for (n = 0; n < count; ++n) {
            shot.passed = fmaxf(shot.passed, bounds[n].distance - bounds[n].upper);
        }
    }
    check(ls_body_linear_velocity_get(world, arrow, velocity));
    shot.speed = velocity[0];
    check(ls_world_destroy(world));
    return shot;
}

int main(void)
{
    static const float STIFFNESS[3] = {500.0f, 2000.0f, 8000.0f};
    Shot shots[3], again;
    int i;
    for (i = 0; i < 3; ++i) {
        shots[i] = shoot(STIFFNESS[i]);
        printf("%5.0f N/m: the arrow flies at %.2f m/s; stops passed by %.2f degrees, bounds by %.2f mm at most\n", STIFFNESS[i],
               shots[i].speed, shots[i].overshoot * 57.29578, shots[i].passed * 1e3);
    }
    again = shoot(STIFFNESS[1]);
    expect(shots[0].speed > 0.5f, "the softest bow shoots");
    expect(shots[0].speed < shots[1].speed && shots[1].speed < shots[2].speed, "the softer the bound, the slower the arrow");
    expect(memcmp(&again, &shots[1], sizeof again) == 0, "the same shot again is the same to the bit");
    for (i = 0; i < 3; ++i) {
        expect(shots[i].passed < 0.002f, "no bound is passed by more than 2 mm");
    }
    return 0;
}
