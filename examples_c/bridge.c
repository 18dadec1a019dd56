/* A footbridge of planks on two ropes between fixed banks, a hundred kilograms hung from its middle: does it keep its length, with the
 * long-range constraints that the library derives from its joints, and without them?
 *
 *     cc bridge.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o bridge && ./bridge
 *
 * Joints are solved by sweeps alone, as long-range constraints are for those; the library's default solves such a bridge at once. */
#include "sample.h"

#include <math.h>

#define PLANKS 24
#define SIDES 2
#define PIECES (PLANKS + 1)
#define STEPS 480
static const float DT = 1.0f / 60.0f;
static const double PITCH = 0.5, SAG = 1.0, HALF_WIDTH = 0.6;
static const float PLANK_HALF[3] = {0.15f, 0.03f, 0.7f}; /* along, up, across (m) */
static const float PLANK_MASS = 10.0f, PIECE_MASS = 0.2f, LOAD_MASS = 100.0f;

typedef struct {
    LsWorld world;
    LsBody banks, planks[PLANKS];
    LsJoint first[SIDES], last[SIDES]; /* of each rope */
} Bridge;

typedef struct {
    float stretch;  /* share */
    double sag;     /* of the middle (m) */
    float tension;  /* greatest in a rope (N) */
    uint32_t bounds, active;
} Outcome;

static double height(double x)
{
    const double u = x / (PITCH * (PLANKS + 1));
    return -4.0 * SAG * u * (1.0 - u);
}

/* A box at x, y, z, turned about z, that touches nothing. */
static LsBody create_box(LsWorld world, const float half[3], float mass, const double at[3], double angle)
{
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    int i;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    shape.filter.collides_with = 0;
    check(ls_body_def_init(&def, sizeof def));
    def.kind = mass > 0.0f ? LS_BODY_DYNAMIC : LS_BODY_STATIC;
    def.mass.kind = mass > 0.0f ? LS_MASS_TOTAL : LS_MASS_FROM_SHAPES;
    def.mass.properties.mass = mass;
    for (i = 0; i < 3; ++i) {
        shape.half_extents[i] = half[i];
        def.pose.position[i] = at[i];
    }
    def.pose.rotation[2] = (float)sin(angle / 2.0);
    def.pose.rotation[3] = (float)cos(angle / 2.0);
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

static LsJoint tie(LsWorld world, LsBody a, const double on_a[3], LsBody b, const double on_b[3])
{
    LsJointDef def;
    LsJoint joint;
    int i;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_SPHERICAL;
    def.body_a = a;
    def.body_b = b;
    for (i = 0; i < 3; ++i) {
        def.frame_a.position[i] = on_a[i];
        def.frame_b.position[i] = on_b[i];
    }
    check(ls_joint_create(world, &def, &joint));
    return joint;
}

/* A rope piece from one point to another at this z, jointed to what is at both ends; returns its first and last joint. */
static void add_piece(LsWorld world, LsBody a, const double on_a[3], const double from[2], LsBody b, const double on_b[3],
                      const double to[2], double z, LsJoint joints[2])
{
    const double length = hypot(to[0] - from[0], to[1] - from[1]);
    const float half[3] = {(float)(length / 2.0), 0.02f, 0.02f};
    const double middle[3] = {(from[0] + to[0]) / 2.0, (from[1] + to[1]) / 2.0, z};
    const double start[3] = {-length / 2.0, 0.0, 0.0}, end[3] = {length / 2.0, 0.0, 0.0};
    const LsBody piece = create_box(world, half, PIECE_MASS, middle, atan2(to[1] - from[1], to[0] - from[0]));
    joints[0] = tie(world, a, on_a, piece, start);
    joints[1] = tie(world, piece, end, b, on_b);
}

static Bridge build(int long_range)
{
    const double span = PITCH * (PLANKS + 1), origin[3] = {0.0, 0.0, 0.0};
    const float bank[3] = {0.05f, 0.05f, 0.05f}, load_half[3] = {0.2f, 0.2f, 0.2f};
    Bridge bridge;
    LsWorldDef def;
    LsLongRangeDef derived;
    LsBody load;
    int i, side;
    check(ls_world_def_init(&def, sizeof def));
    def.solver = LS_SOLVER_GAUSS_SEIDEL;
    check(ls_world_create(&def, &bridge.world));
    check(ls_long_range_def_init(&derived, sizeof derived));
    derived.enabled = (uint32_t)long_range;
    check(ls_world_long_range_set(bridge.world, &derived));

    bridge.banks = create_box(bridge.world, bank, 0.0f, origin, 0.0);
    for (i = 0; i < PLANKS; ++i) {
        const double x = PITCH * (i + 1), at[3] = {x, height(x), 0.0};
        bridge.planks[i] = create_box(bridge.world, PLANK_HALF, PLANK_MASS, at, 0.0);
    }
    for (side = 0; side < SIDES; ++side) {
        const double z = side ? HALF_WIDTH : -HALF_WIDTH;
        for (i = 0; i < PIECES; ++i) {
            const double x = PITCH * i, before = i > 0 ? PLANK_HALF[0] : 0.0, after = i < PLANKS ? PLANK_HALF[0] : 0.0;
            const double from[2] = {x + before, i > 0 ? height(x) : 0.0};
            const double to[2] = {x + PITCH - after, i < PLANKS ? height(x + PITCH) : 0.0};
            const double on_left[3] = {before, 0.0, z}, on_right[3] = {-after, 0.0, z};
            const double left_bank[3] = {0.0, 0.0, z}, right_bank[3] = {span, 0.0, z};
            LsJoint joints[2];
            add_piece(bridge.world, i > 0 ? bridge.planks[i - 1] : bridge.banks, i > 0 ? on_left : left_bank, from,
                      i < PLANKS ? bridge.planks[i] : bridge.banks, i < PLANKS ? on_right : right_bank, to, z, joints);
            if (i == 0) {
                bridge.first[side] = joints[0];
            }
            bridge.last[side] = joints[1];
        }
    }
    /* A hundred kilograms hang from the middle plank by a joint of their own. */
    {
        const double x = PITCH * (PLANKS / 2), at[3] = {x, height(x) - 0.4, 0.0};
        const double below[3] = {0.0, -0.2, 0.0}, above[3] = {0.0, 0.2, 0.0};
        load = create_box(bridge.world, load_half, LOAD_MASS, at, 0.0);
        tie(bridge.world, bridge.planks[PLANKS / 2 - 1], below, load, above);
    }
    return bridge;
}

static Outcome run(int long_range)
{
    const Bridge bridge = build(long_range);
    Outcome outcome = {0.0f, 0.0, 0.0f, 0, 0};
    LsStepReport report;
    LsPose pose;
    int step, side;
    for (step = 0; step < STEPS; ++step) {
        step_world(bridge.world, DT);
    }
    for (side = 0; side < SIDES; ++side) {
        LsChainState rope;
        check(ls_chain_state_get(bridge.world, bridge.first[side], bridge.last[side], &rope, sizeof rope));
        outcome.stretch = fmaxf(outcome.stretch, rope.stretch);
        outcome.tension = fmaxf(outcome.tension, rope.greatest_tension);
    }
    check(ls_body_pose_get(bridge.world, bridge.planks[PLANKS / 2 - 1], &pose));
    outcome.sag = -pose.position[1];
    check(ls_world_report_get(bridge.world, &report, sizeof report));
    outcome.bounds = report.bounds;
    outcome.active = report.bounds_active;
    check(ls_world_destroy(bridge.world));
    return outcome;
}

int main(void)
{
    const Outcome with = run(1), without = run(0);
    printf("with long-range constraints:    ropes stretched by %.3f %%, middle %.2f m down, %.0f N at most, %u of %u bounds taut\n",
           100.0 * with.stretch, with.sag, with.tension, with.active, with.bounds);
    printf("without long-range constraints: ropes stretched by %.3f %%, middle %.2f m down\n", 100.0 * without.stretch, without.sag);
    expect(with.stretch < 0.005f, "the ropes keep their length to half a per cent");
    expect(without.stretch > 10.0f * with.stretch, "sweeps alone let them stretch at least ten times as far");
    expect(with.bounds > 0 && without.bounds == 0, "bounds are derived only where that is on");
    return 0;
}
