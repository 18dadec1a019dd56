/* What falls if I take this away? A gate of two posts, a lintel and a finial is asked, and then loses a post.
 *
 *     cc keystone.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o keystone && ./keystone
 *
 * The answer comes from the graph of contacts, joints and hulls; nothing is simulated for it. Afterwards it is compared with what does
 * fall. */
#include "sample.h"

enum { LEFT, RIGHT, LINTEL, FINIAL, ASIDE, PARTS };
static const char *const NAMES[PARTS] = {"left post", "right post", "lintel", "finial", "block aside"};
/* Half extents and centre (m). */
static const float HALF[PARTS][3] = {{0.2f, 1.0f, 0.2f}, {0.2f, 1.0f, 0.2f}, {1.4f, 0.2f, 0.3f}, {0.2f, 0.2f, 0.2f}, {0.3f, 0.3f, 0.3f}};
static const double CENTER[PARTS][2] = {{-1.0, 1.0}, {1.0, 1.0}, {0.0, 2.2}, {0.0, 2.6}, {4.0, 0.3}};

static LsBody create_block(LsWorld world, const float half[3], double x, double y)
{
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body;
    int i;
    check(ls_shape_def_init(&shape, sizeof shape));
    shape.kind = LS_SHAPE_BOX;
    for (i = 0; i < 3; ++i) {
        shape.half_extents[i] = half[i];
    }
    check(ls_body_def_init(&def, sizeof def));
    def.kind = half[0] > 5.0f ? LS_BODY_STATIC : LS_BODY_DYNAMIC;
    def.pose.position[0] = x;
    def.pose.position[1] = y;
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &body));
    return body;
}

static void step_for(LsWorld world, int steps)
{
    while (steps-- > 0) {
        step_world(world, 1.0f / 60.0f);
    }
}

int main(void)
{
    static const float FLOOR[3] = {20.0f, 0.5f, 20.0f};
    LsWorldDef def;
    LsWorld world;
    LsBody parts[PARTS], lost[PARTS];
    LsPose pose;
    size_t count, k;
    float load;
    int i;

    check(ls_world_def_init(&def, sizeof def));
    def.support = 1;
    check(ls_world_create(&def, &world));
    create_block(world, FLOOR, 0.0, -0.5);
    for (i = 0; i < PARTS; ++i) {
        parts[i] = create_block(world, HALF[i], CENTER[i][0], CENTER[i][1]);
    }
    step_for(world, 60);
    check(ls_support_load_get(world, parts[LEFT], &load));
    printf("the left post carries %.0f N\n", (double)load);

    check(ls_support_loss_predict(world, &parts[LEFT], 1, lost, PARTS, &count));
    printf("without it, support is lost by %u:", (unsigned)count);
    for (k = 0; k < count; ++k) {
        for (i = 0; i < PARTS; ++i) {
            if (lost[k].id == parts[i].id) {
                printf(" %s;", NAMES[i]);
            }
        }
    }
    printf("\n");

    check(ls_body_destroy(world, parts[LEFT]));
    step_for(world, 60);
    for (i = RIGHT; i < PARTS; ++i) {
        int was_named = 0, fell;
        for (k = 0; k < count; ++k) {
            was_named |= lost[k].id == parts[i].id;
        }
        check(ls_body_pose_get(world, parts[i], &pose));
        fell = pose.position[1] < CENTER[i][1] - 0.1;
        printf("%-12s %s\n", NAMES[i], fell ? "fell" : "stands");
        if (was_named) {
            expect(fell, "what loses its support falls");
        }
        if (i == ASIDE) {
            expect(!fell && !was_named, "what stands by itself stays");
        }
    }
    expect(count >= 2, "lintel and finial need both posts");
    check(ls_world_destroy(world));
    return 0;
}
