/* What a world sees of itself, layer by layer: a host hands over three functions that draw, here they count.
 *
 *     cc debug_draw.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o debug_draw && ./debug_draw
 *
 * Two crates stand on the ground, and a rope of four links hangs from a hook, once loose and once with a weight on it. */
#include "sample.h"

#include <math.h>
#include <string.h>

#define LINKS 4

typedef struct Drawing {
    int lines, triangles, texts;
    double lowest, highest; /* of all ends of lines (m) */
    char last_text[64];
    LsWorld world;
    LsBody any;
} Drawing;

static void note(Drawing *drawing, const double *point)
{
    drawing->lowest = fmin(drawing->lowest, point[1]);
    drawing->highest = fmax(drawing->highest, point[1]);
}

static void line(const double *from, const double *to, uint32_t color, void *user)
{
    Drawing *drawing = (Drawing *)user;
    expect(color <= 0xFFFFFF && isfinite(from[0] + to[0]), "a line has a colour and two points");
    ++drawing->lines;
    note(drawing, from);
    note(drawing, to);
}

static void triangle(const double *corners, uint32_t color, void *user)
{
    (void)color;
    expect(isfinite(corners[0] + corners[3] + corners[6]), "a triangle has three corners");
    ++((Drawing *)user)->triangles;
}

static void text(const double *at, const char *words, uint32_t color, void *user)
{
    Drawing *drawing = (Drawing *)user;
    LsPose pose;
    (void)at;
    (void)color;
    ++drawing->texts;
    strncpy(drawing->last_text, words, sizeof drawing->last_text - 1);
    /* While it draws, the host may look at the world, but not change it. */
    check(ls_body_pose_get(drawing->world, drawing->any, &pose));
    expect(ls_body_wake(drawing->world, drawing->any) == LS_ERROR_WORLD_LOCKED, "drawing cannot change a world");
}

static Drawing draw(LsWorld world, LsBody any, uint32_t layers)
{
    Drawing drawing = {0, 0, 0, 1e9, -1e9, "", {0}, {0}};
    LsDraw order;
    drawing.world = world;
    drawing.any = any;
    check(ls_draw_init(&order, sizeof order));
    order.layers = layers;
    order.line = line;
    order.triangle = triangle;
    order.text = text;
    order.user = &drawing;
    check(ls_world_draw(world, &order));
    return drawing;
}

static LsBody hang_rope(LsWorld world)
{
    LsBody last = create_body(world, LS_BODY_STATIC, LS_SHAPE_BALL, 5, 10);
    LsJointDef def;
    LsJoint joint;
    int i;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_SPHERICAL;
    for (i = 0; i < LINKS; ++i) {
        def.body_a = last;
        def.body_b = last = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 6 + i, 10);
        def.frame_a.position[0] = 0.5;
        def.frame_b.position[0] = -0.5;
        check(ls_joint_create(world, &def, &joint));
    }
    return last;
}

/* A chain of hinges keeps to a plane, and what fixed joints hold is one body. */
static void draw_structures(void)
{
    LsWorld world = create_world();
    LsBody last = create_body(world, LS_BODY_STATIC, LS_SHAPE_BALL, 0, 10), welded[2];
    LsJointDef def;
    LsJoint joint;
    Drawing drawn;
    int i;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_HINGE;
    for (i = 0; i < LINKS; ++i) {
        def.body_a = last;
        def.body_b = last = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0, 9 - i);
        def.frame_a.position[1] = -0.5;
        def.frame_b.position[1] = 0.5;
        check(ls_joint_create(world, &def, &joint));
    }
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_FIXED;
    def.body_a = welded[0] = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 5, 5);
    def.body_b = welded[1] = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 6, 5);
    def.frame_a.position[0] = 0.5;
    def.frame_b.position[0] = -0.5;
    check(ls_joint_create(world, &def, &joint));
    check(ls_world_step(world, 1.0f / 60.0f));
    drawn = draw(world, last, LS_DRAW_PLANES);
    printf("%-14s %4d lines %4d triangles %2d texts: %s\n", "planes", drawn.lines, drawn.triangles, drawn.texts, drawn.last_text);
    expect(drawn.lines == 4 + 4 + 4 * LINKS && strcmp(drawn.last_text, "plane of 4") == 0, "a square, a normal, and each link's place");
    drawn = draw(world, welded[0], LS_DRAW_UNIONS);
    printf("%-14s %4d lines %4d triangles %2d texts: %s\n", "unions", drawn.lines, drawn.triangles, drawn.texts, drawn.last_text);
    expect(drawn.lines == 3 + 2 && strcmp(drawn.last_text, "2 bodies") == 0, "a cross, and a line to each body");
    check(ls_world_destroy(world));
}

int main(void)
{
    static const struct {
        uint32_t layer;
        const char *name;
    } layers[] = {
        {LS_DRAW_SHAPES, "shapes"}, {LS_DRAW_SURFACES, "surfaces"},         {LS_DRAW_CONTACTS, "contacts"},
        {LS_DRAW_CONTACT_FORCES, "contact forces"},                         {LS_DRAW_JOINTS, "joints"},
        {LS_DRAW_JOINT_LIMITS, "joint limits"},                             {LS_DRAW_JOINT_LOADS, "joint loads"},
        {LS_DRAW_ISLANDS, "islands"}, {LS_DRAW_BOUNDS, "bounds"},           {LS_DRAW_SUPPORT, "support"},
        {LS_DRAW_MASS, "mass"},     {LS_DRAW_VELOCITIES, "velocities"},     {LS_DRAW_BOXES, "boxes"},
    };
    LsWorld world = create_world();
    LsBody crate, end;
    LsDraw far;
    Drawing drawn;
    size_t i;
    int step;

    check(ls_support_enabled_set(world, 1));
    create_body(world, LS_BODY_STATIC, LS_SHAPE_BOX, 0, -0.5);
    crate = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0, 0.5);
    create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0.2, 1.5);
    end = hang_rope(world);
    for (step = 0; step < 10; ++step) {
        check(ls_world_step(world, 1.0f / 60.0f));
    }
    for (i = 0; i < sizeof layers / sizeof layers[0]; ++i) {
        drawn = draw(world, crate, layers[i].layer);
        printf("%-14s %4d lines %4d triangles %2d texts\n", layers[i].name, drawn.lines, drawn.triangles, drawn.texts);
        switch (layers[i].layer) {
        case LS_DRAW_SHAPES: /* seven boxes of twelve edges, and the circles of a ball */
            expect(drawn.lines > 7 * 12 && fabs(drawn.lowest + 1.0) < 1e-3 && fabs(drawn.highest - 10.5) < 0.05, "outlines");
            break;
        case LS_DRAW_SURFACES:
            expect(drawn.triangles > 7 * 12 && drawn.lines == 0, "surfaces");
            break;
        case LS_DRAW_CONTACTS: /* two faces of four points: a cross of three lines and a normal each */
            expect(drawn.lines == 2 * 4 * 4 && fabs(drawn.highest - 1.1) < 0.01, "contacts at heights 0 and 1 m");
            break;
        case LS_DRAW_CONTACT_FORCES:
            expect(drawn.lines >= 2 * 4, "an arrow for each force");
            break;
        case LS_DRAW_JOINTS: /* two levers, two frames and the gap */
            expect(drawn.lines == LINKS * 9, "joints");
            break;
        case LS_DRAW_JOINT_LIMITS: /* a free spherical joint has none: where it points to */
            expect(drawn.lines == LINKS, "joint limits");
            break;
        case LS_DRAW_JOINT_LOADS:
            expect(drawn.texts == LINKS && strstr(drawn.last_text, " N") != NULL, "joint loads in newtons");
            break;
        case LS_DRAW_ISLANDS: /* the crates, and the rope */
            expect(drawn.lines == 2 * 12, "islands");
            break;
        case LS_DRAW_BOUNDS:
            expect(drawn.lines >= LINKS - 1 && drawn.texts == drawn.lines, "a line and a text for each bound");
            break;
        case LS_DRAW_SUPPORT:
            expect(drawn.lines > 2 * (3 + 4 * 3 + 4) && drawn.triangles == 2 * 2, "hulls of two crates");
            break;
        case LS_DRAW_MASS:
            expect(drawn.lines == (2 + LINKS) * 3, "axes of every dynamic body");
            break;
        case LS_DRAW_VELOCITIES:
            expect(drawn.lines >= LINKS, "the rope swings");
            break;
        default:
            expect(drawn.lines == 8 * 12, "a box for each shape");
        }
    }
    drawn = draw(world, crate, LS_DRAW_BOUNDS);
    printf("the rope's ends: slack %s\n", drawn.last_text);
    expect(strstr(drawn.last_text, " m") != NULL || strstr(drawn.last_text, " N") != NULL, "slack or tension");

    check(ls_draw_init(&far, sizeof far));
    far.line = line;
    far.user = &drawn;
    far.only_near = 1;
    far.center[0] = 1000;
    far.radius = 10;
    drawn.lines = 0;
    check(ls_world_draw(world, &far));
    expect(drawn.lines == 0, "nothing is near there");
    far.layers = 1u << 31;
    expect(ls_world_draw(world, &far) == LS_ERROR_INVALID_ENUM, "a layer that is not known is refused");
    (void)end;
    check(ls_world_destroy(world));
    draw_structures();
    return 0;
}
