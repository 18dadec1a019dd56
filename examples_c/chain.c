/* Ten tonnes on a chain of one-kilogram links: how far does the chain stretch, and what does its top joint read?
 *
 *     cc chain.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o chain && ./chain
 *
 * ./chain MASS hangs another mass (kg) below it. ./chain MASS FILE also writes one line a body into the file, to draw a picture
 * from: kind, dimensions (half extents, or half height and radius), position, rotation (x y z w). */

#include "sample.h"

#include <math.h>

#define LINKS 30
#define JOINTS (LINKS + 1)
#define STEPS 600
static const float DT = 1.0f / 60.0f;
static const float LINK_LENGTH = 0.2f; /* from joint to joint (m) */
static const float LINK_RADIUS = 0.02f;
static const float LINK_MASS = 1.0f;
static const float WEIGHT_HALF_EXTENT = 0.5f;
static const float GRAVITY = 9.81f;

/* A body of one shape at height y. */
static LsBody create_part(LsWorld world, int kind, const LsShapeDef *shape, float mass, double y, float sideways)
{
    LsBodyDef def;
    LsBody body;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = kind;
    def.pose.position[1] = y;
    def.linear_velocity[0] = sideways;
    def.mass.kind = LS_MASS_TOTAL;
    def.mass.properties.mass = mass;
    def.shapes = shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

/* A spherical joint between points on the y axes of two bodies. */
static LsJoint create_joint(LsWorld world, LsBody upper, double upper_y, LsBody lower, double lower_y)
{
    LsJointDef def;
    LsJoint joint;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_SPHERICAL;
    def.body_a = upper;
    def.body_b = lower;
    def.frame_a.position[1] = upper_y;
    def.frame_b.position[1] = lower_y;
    check(ls_joint_create(world, &def, &joint));
    return joint;
}

/* World position of a point on a body's y axis. */
static void point_on(const LsPose *pose, double y, double out[3])
{
    const double qx = pose->rotation[0], qy = pose->rotation[1], qz = pose->rotation[2], qw = pose->rotation[3];
    out[0] = pose->position[0] + y * 2.0 * (qx * qy - qw * qz);
    out[1] = pose->position[1] + y * (1.0 - 2.0 * (qx * qx + qz * qz));
    out[2] = pose->position[2] + y * 2.0 * (qy * qz + qw * qx);
}

static double distance(const double a[3], const double b[3])
{
    const double x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
    return sqrt(x * x + y * y + z * z);
}

static void write_picture(const char *path, const LsPose *poses, int count)
{
    FILE *file = fopen(path, "w");
    int i;
    if (file == NULL) {
        perror(path);
        exit(1);
    }
    for (i = 0; i < count; ++i) {
        const LsPose *p = &poses[i];
        if (i == 0 || i == count - 1) {
            const double half = i == 0 ? 0.1 : WEIGHT_HALF_EXTENT;
            fprintf(file, "box %.9g %.9g %.9g", half, half, half);
        } else {
            fprintf(file, "capsule %.9g %.9g", (double)(LINK_LENGTH / 2 - LINK_RADIUS), (double)LINK_RADIUS);
        }
        fprintf(file, " %.17g %.17g %.17g %.9g %.9g %.9g %.9g\n", p->position[0], p->position[1], p->position[2],
                p->rotation[0], p->rotation[1], p->rotation[2], p->rotation[3]);
    }
    fclose(file);
}

int main(int argc, char **argv)
{
    const float weight_mass = argc > 1 ? (float)atof(argv[1]) : 10000.0f; /* the library refuses what is not positive */
    LsWorldDef world_def;
    LsShapeDef shape;
    LsWorld world;
    LsBody bodies[LINKS + 2]; /* anchor, links, weight */
    LsPose poses[LINKS + 2];
    double above[LINKS + 2], below[LINKS + 2]; /* joint points of each body on its own y axis */
    LsJoint top = {0};
    LsJointState state;
    double length = 0.0, rest = 0.0, worst_gap = 0.0, previous[3], from[3], to[3];
    double force, load, cpu;
    clock_t start;
    int i, step;

    check(ls_world_def_init(&world_def, sizeof world_def));
    world_def.sleep.enabled = 0;
    check(ls_world_create(&world_def, &world));

    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    shape.half_extents[0] = shape.half_extents[1] = shape.half_extents[2] = 0.1f;
    bodies[0] = create_part(world, LS_BODY_STATIC, &shape, 1.0f, 0.1, 0.0f);
    below[0] = -0.1;

    shape.kind = LS_SHAPE_CAPSULE;
    shape.half_height = LINK_LENGTH / 2 - LINK_RADIUS;
    shape.radius = LINK_RADIUS;
    for (i = 1; i <= LINKS; ++i) {
        above[i] = LINK_LENGTH / 2;
        below[i] = -LINK_LENGTH / 2;
        bodies[i] = create_part(world, LS_BODY_DYNAMIC, &shape, LINK_MASS, -(i - 0.5) * LINK_LENGTH, 0.0f);
    }

    shape.kind = LS_SHAPE_BOX;
    shape.half_extents[0] = shape.half_extents[1] = shape.half_extents[2] = WEIGHT_HALF_EXTENT;
    above[LINKS + 1] = WEIGHT_HALF_EXTENT;
    bodies[LINKS + 1] = create_part(world, LS_BODY_DYNAMIC, &shape, weight_mass,
                                    -LINKS * (double)LINK_LENGTH - WEIGHT_HALF_EXTENT, 0.2f);
    for (i = 0; i < JOINTS; ++i) {
        LsJoint joint = create_joint(world, bodies[i], below[i], bodies[i + 1], above[i + 1]);
        if (i == 0) {
            top = joint;
        }
    }

    start = clock();
    for (step = 0; step < STEPS; ++step) {
        step_world(world, DT);
    }
    cpu = (double)(clock() - start) / CLOCKS_PER_SEC;

    /* The path runs through all joints, gaps included: from each body's upper point to its lower one, and on to the next. */
    check(ls_world_poses_get(world, bodies, LINKS + 2, poses));
    point_on(&poses[0], below[0], previous);
    for (i = 1; i <= LINKS + 1; ++i) {
        double gap;
        point_on(&poses[i], above[i], from);
        gap = distance(previous, from);
        length += gap;
        worst_gap = gap > worst_gap ? gap : worst_gap;
        if (i <= LINKS) {
            point_on(&poses[i], below[i], to);
            length += distance(from, to);
            rest += LINK_LENGTH;
            previous[0] = to[0];
            previous[1] = to[1];
            previous[2] = to[2];
        }
    }

    check(ls_joint_state_get(world, top, &state, sizeof state));
    force = sqrt((double)state.force[0] * state.force[0] + (double)state.force[1] * state.force[1] +
                 (double)state.force[2] * state.force[2]);
    load = ((double)weight_mass + LINKS * (double)LINK_MASS) * GRAVITY;
    printf("stretch       %.6f %%\n", 100.0 * (length / rest - 1.0));
    printf("worst gap     %.9f m\n", worst_gap);
    printf("top joint     %.1f N of %.1f N below it (%+.3f %%)\n", force, load, 100.0 * (force / load - 1.0));
    printf("CPU time      %.6f ms a step\n", 1000.0 * cpu / STEPS);
    if (argc > 2) {
        write_picture(argv[2], poses, LINKS + 2);
    }
    check(ls_world_destroy(world));
    return 0;
}
