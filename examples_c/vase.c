/* A vase of welded pieces falls on its edge and breaks; every broken weld and every union that falls apart is told.
 *
 *     cc vase.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o vase && ./vase
 *
 * ./vase STRESS sets what the welds bear (Pa). */

#include "sample.h"

#include <math.h>

#define RINGS 6
#define AROUND 10
#define PIECES (RINGS * AROUND)
#define STEPS 240
static const float DT = 1.0f / 60.0f;
static const float RADII[RINGS] = {0.28f, 0.36f, 0.42f, 0.40f, 0.32f, 0.24f};
static const float RING_HEIGHT = 0.16f; /* (m) */
static const float HALF_WALL = 0.025f;
static const float TILT = 0.61f; /* of the vase's axis (rad) */
static const float DROP = 2.0f;  /* of its foot (m) */
static const float PI = 3.14159265f;

typedef struct Told {
    int joints, splits, loose_pieces, edits_refused;
} Told;

static const char *const LIMITS[] = {"tension", "compression", "shear", "bending", "torsion"};

/* Tells of a broken weld. The world cannot be edited from here: the call says so, and nothing waits. */
static void on_break(LsWorld world, const LsJointBreak *broken, void *user)
{
    Told *told = (Told *)user;
    const float *f = broken->force, *t = broken->torque;
    printf("step %3u  weld %3u breaks in %-11s  %7.0f N  %7.1f N m  %5.2f of its limit\n", (unsigned)broken->step,
           (unsigned)broken->user_word, LIMITS[broken->limit], sqrt((double)(f[0] * f[0] + f[1] * f[1] + f[2] * f[2])),
           sqrt((double)(t[0] * t[0] + t[1] * t[1] + t[2] * t[2])), (double)broken->share);
    ++told->joints;
    told->edits_refused += ls_body_destroy(world, broken->body_a) == LS_ERROR_WORLD_LOCKED;
}

/* Tells of a union that has fallen apart, and of its pieces: these can be read from here. */
static void on_split(LsWorld world, const LsSplit *split, void *user)
{
    Told *told = (Told *)user;
    const LsPiece *pieces;
    size_t count;
    uint32_t i;
    check(ls_world_pieces_get(world, &pieces, &count));
    printf("step %3u  a union of %u pieces, %.1f kg, falls into %u:", (unsigned)split->step, split->body_count,
           (double)split->mass, split->piece_count);
    for (i = 0; i < split->piece_count; ++i) {
        printf(" %u", pieces[split->first_piece + i].body_count);
        told->loose_pieces += (int)(pieces[split->first_piece + i].cut_loose);
    }
    printf("\n");
    ++told->splits;
}

/* out = v, turned by TILT about z. */
static void tilted(float x, float y, float z, double out[3])
{
    out[0] = (double)(x * cosf(TILT) - y * sinf(TILT));
    out[1] = (double)(x * sinf(TILT) + y * cosf(TILT));
    out[2] = (double)z;
}

/* Piece of a ring; its x axis points out, its y axis up the vase. */
static LsBody create_piece(LsWorld world, int ring, int place, LsPose *pose)
{
    const float angle = 2.0f * PI * (float)place / AROUND, radius = RADII[ring];
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    shape.half_extents[0] = HALF_WALL;
    shape.half_extents[1] = 0.495f * RING_HEIGHT;
    shape.half_extents[2] = 0.99f * radius * tanf(PI / AROUND);
    check(ls_body_def_init(&def, sizeof def));
    tilted(radius * cosf(angle), ((float)ring + 0.5f) * RING_HEIGHT, -radius * sinf(angle), def.pose.position);
    def.pose.position[1] += (double)DROP;
    def.pose.rotation[0] = -sinf(0.5f * TILT) * sinf(0.5f * angle);
    def.pose.rotation[1] = cosf(0.5f * TILT) * sinf(0.5f * angle);
    def.pose.rotation[2] = sinf(0.5f * TILT) * cosf(0.5f * angle);
    def.pose.rotation[3] = cosf(0.5f * TILT) * cosf(0.5f * angle);
    def.fast = 1;
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    *pose = def.pose;
    return body;
}

/* p in the frame of pose. */
static void local_point(const LsPose *pose, const double p[3], double out[3])
{
    const double x = -(double)pose->rotation[0], y = -(double)pose->rotation[1], z = -(double)pose->rotation[2];
    const double w = (double)pose->rotation[3];
    const double a = p[0] - pose->position[0], b = p[1] - pose->position[1], c = p[2] - pose->position[2];
    const double u = 2.0 * (y * c - z * b), v = 2.0 * (z * a - x * c), t = 2.0 * (x * b - y * a);
    out[0] = a + w * u + y * t - z * v;
    out[1] = b + w * v + z * u - x * t;
    out[2] = c + w * t + x * v - y * u;
}

/* A weld halfway between two pieces that bears `stress` over `area` (m2); its frames agree in the world: both are its axes. */
static void weld(LsWorld world, const LsBody bodies[2], const LsPose poses[2], float area, float stress, unsigned number)
{
    const float radius = sqrtf(area / PI);
    LsJointDef def;
    LsJoint joint;
    double middle[3];
    int i;
    for (i = 0; i < 3; ++i)
        middle[i] = 0.5 * (poses[0].position[i] + poses[1].position[i]);
    check(ls_joint_def_init(&def, sizeof def));
    def.body_a = bodies[0];
    def.body_b = bodies[1];
    local_point(&poses[0], middle, def.frame_a.position);
    local_point(&poses[1], middle, def.frame_b.position);
    for (i = 0; i < 3; ++i) {
        def.frame_a.rotation[i] = -poses[0].rotation[i];
        def.frame_b.rotation[i] = -poses[1].rotation[i];
    }
    def.frame_a.rotation[3] = poses[0].rotation[3];
    def.frame_b.rotation[3] = poses[1].rotation[3];
    def.strength.tension = def.strength.compression = def.strength.shear = stress * area;
    def.strength.bending = def.strength.torsion = 0.25f * stress * area * radius;
    def.user_word = number;
    check(ls_joint_create(world, &def, &joint));
}

int main(int argc, char **argv)
{
    const float stress = argc > 1 ? (float)atof(argv[1]) : 2.0e6f;
    LsWorldDef def;
    LsWorld world;
    LsBody floor_body, pieces[PIECES];
    LsPose poses[PIECES];
    LsBodyDef floor_def;
    LsShapeDef floor_shape;
    Told told = {0, 0, 0, 0};
    unsigned welds = 0;
    int step, i;

    check(ls_world_def_init(&def, sizeof def));
    check(ls_world_create(&def, &world));
    check(ls_shape_def_init(&floor_shape, sizeof floor_shape));
    floor_shape.kind = LS_SHAPE_HALF_SPACE;
    check(ls_body_def_init(&floor_def, sizeof floor_def));
    floor_def.kind = LS_BODY_STATIC;
    floor_def.shapes = &floor_shape;
    floor_def.shape_count = 1;
    check(ls_body_create(world, &floor_def, &floor_body));

    for (i = 0; i < PIECES; ++i)
        pieces[i] = create_piece(world, i / AROUND, i % AROUND, &poses[i]);
    for (i = 0; i < PIECES; ++i) {
        const int next = i / AROUND * AROUND + (i + 1) % AROUND, above = i + AROUND;
        const LsBody beside[2] = {pieces[i], pieces[next]};
        const LsPose beside_poses[2] = {poses[i], poses[next]};
        weld(world, beside, beside_poses, 2.0f * HALF_WALL * RING_HEIGHT, stress, welds++);
        if (above < PIECES) {
            const LsBody stacked[2] = {pieces[i], pieces[above]};
            const LsPose stacked_poses[2] = {poses[i], poses[above]};
            const float radius = fminf(RADII[i / AROUND], RADII[above / AROUND]);
            weld(world, stacked, stacked_poses, 4.0f * HALF_WALL * radius * tanf(PI / AROUND), stress, welds++);
        }
    }
    check(ls_world_break_callback_set(world, on_break, &told));
    check(ls_world_split_callback_set(world, on_split, &told));

    for (step = 0; step < STEPS; ++step)
        step_world(world, DT);

    printf("%d of %u welds broke, %d unions fell apart\n", told.joints, welds, told.splits);
    check(ls_world_destroy(world));
    return told.joints > 0 && told.edits_refused == told.joints && told.loose_pieces == 0 ? 0 : 1;
}
