/* Everything about a live world can be changed and read back: mass, damping, axes, form, surface, joints, effort.
 *
 *     cc edit.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o edit && ./edit
 *
 * Exits with 1 at the first value that does not come back as it was set. */
#include "sample.h"

#include <string.h>

static int changes = 0;

static void came_back(int as_set, const char *what)
{
    ++changes;
    if (!as_set) {
        fprintf(stderr, "%s did not come back as it was set\n", what);
        exit(1);
    }
}

static LsShape first_shape(LsWorld world, LsBody body)
{
    LsShape shape;
    size_t count;
    check(ls_body_shapes_get(world, body, &shape, 1, &count));
    return shape;
}

static void edit_body(LsWorld world, LsBody body)
{
    float linear, angular, scale;
    uint32_t axes, flag;
    LsMass mass = {LS_MASS_TOTAL, {0, {0, 0, 0}, {0, 0, 0}, {0, 0, 0, 0}}};
    LsMassProperties properties;

    check(ls_body_damping_set(world, body, 0.25f, 0.5f));
    check(ls_body_damping_get(world, body, &linear, &angular));
    came_back(linear == 0.25f && angular == 0.5f, "damping");
    check(ls_body_gravity_scale_set(world, body, 0.5f));
    check(ls_body_gravity_scale_get(world, body, &scale));
    came_back(scale == 0.5f, "gravity scale");
    check(ls_body_locked_axes_set(world, body, LS_LOCK_TRANSLATION_Z | LS_LOCK_ROTATION_X | LS_LOCK_ROTATION_Y));
    check(ls_body_locked_axes_get(world, body, &axes));
    came_back(axes == (LS_LOCK_TRANSLATION_Z | LS_LOCK_ROTATION_X | LS_LOCK_ROTATION_Y), "locked axes");
    check(ls_body_fast_set(world, body, 1));
    check(ls_body_fast_get(world, body, &flag));
    came_back(flag == 1, "fast");
    check(ls_body_can_sleep_set(world, body, 0));
    check(ls_body_can_sleep_get(world, body, &flag));
    came_back(flag == 0, "can sleep");
    mass.properties.mass = 12.0f;
    check(ls_body_mass_set(world, body, &mass));
    check(ls_body_mass_get(world, body, &properties));
    came_back(properties.mass == 12.0f, "mass");
}

static void edit_shape(LsWorld world, LsShape shape)
{
    static const float corners[] = {-0.5f, -0.5f, -0.5f, 0.5f, -0.5f, -0.5f, 0.0f, -0.5f, 0.5f, 0.0f, 0.5f, 0.0f};
    LsShapeDef def;
    LsMaterial material;
    LsCollisionFilter filter = {2, 3}, filter_now;
    uint64_t word;

    check(ls_shape_material_get(world, shape, &material));
    came_back(material.friction == 0.5f, "default friction");
    material.restitution = 0.5f;
    check(ls_shape_material_set(world, shape, &material));
    material.restitution = 0.0f;
    check(ls_shape_material_get(world, shape, &material));
    came_back(material.restitution == 0.5f, "restitution");
    check(ls_shape_filter_set(world, shape, &filter));
    check(ls_shape_filter_get(world, shape, &filter_now));
    came_back(memcmp(&filter, &filter_now, sizeof filter) == 0, "filter");
    check(ls_shape_user_word_set(world, shape, 77));
    check(ls_shape_user_word_get(world, shape, &word));
    came_back(word == 77, "the shape's word");

    check(ls_shape_def_get(world, shape, &def, sizeof def));
    came_back(def.kind == LS_SHAPE_BOX && def.half_extents[2] == 0.5f && def.user_word == 77, "the shape's definition");
    def.kind = LS_SHAPE_CONVEX_HULL;
    def.points = corners;
    def.point_count = 4;
    check(ls_shape_def_set(world, shape, &def));
    memset(&def, 0, sizeof def);
    check(ls_shape_def_get(world, shape, &def, sizeof def));
    came_back(def.kind == LS_SHAPE_CONVEX_HULL && def.point_count == 4 && def.points[9] == 0.0f && def.points[10] == 0.5f,
              "the shape's new form");
}

static void edit_compound(LsWorld world, LsShape shape)
{
    LsShapeDef parts[2], def, part;
    check(ls_shape_def_init(&parts[0], sizeof parts[0]));
    parts[1] = parts[0];
    parts[1].kind = LS_SHAPE_CAPSULE;
    parts[1].local_position[1] = 1.0f;
    check(ls_shape_def_init(&def, sizeof def));
    def.kind = LS_SHAPE_COMPOUND;
    def.parts = parts;
    def.part_count = 2;
    check(ls_shape_def_set(world, shape, &def));
    check(ls_shape_def_get(world, shape, &def, sizeof def));
    check(ls_shape_part_get(world, shape, 1, &part, sizeof part));
    came_back(def.part_count == 2 && part.kind == LS_SHAPE_CAPSULE && part.local_position[1] == 1.0f, "a compound's part");
}

static void edit_joint(LsWorld world, LsBody upper, LsBody lower)
{
    LsJointDef def;
    LsJoint joint;
    LsPose above = {{0, 2, 0}, {0, 0, 0, 1}}, below = {{0, -1, 0}, {0, 0, 0, 1}};
    uint64_t word;
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_HINGE;
    def.body_a = upper;
    def.body_b = lower;
    check(ls_joint_create(world, &def, &joint));
    check(ls_joint_frames_set(world, joint, &below, &above));
    check(ls_joint_user_word_set(world, joint, 5));
    check(ls_joint_user_word_get(world, joint, &word));
    check(ls_joint_def_get(world, joint, &def, sizeof def));
    came_back(def.frame_a.position[1] == -1.0 && def.frame_b.position[1] == 2.0 && word == 5, "a joint's frames");
    def.limits.min = -0.5f;
    def.limits.max = 0.5f;
    check(ls_joint_kind_set(world, joint, &def));
    check(ls_joint_def_get(world, joint, &def, sizeof def));
    came_back(def.limits.max == 0.5f, "a joint's limits");
}

static void edit_world(LsWorld world)
{
    LsWorldDef def;
    LsSleepSettings sleep = {1, 0.1f, 0.2f, 1.0f};
    check(ls_world_effort_set(world, 8, 3));
    check(ls_world_sleep_settings_set(world, &sleep));
    check(ls_world_restitution_threshold_set(world, 0.5f));
    check(ls_world_def_get(world, &def, sizeof def));
    came_back(def.substeps == 8 && def.iterations == 3, "effort");
    came_back(memcmp(&def.sleep, &sleep, sizeof sleep) == 0 && def.restitution_threshold == 0.5f, "sleep settings");
}

int main(void)
{
    LsWorldDef def;
    LsWorld world;
    LsBody ground, body, hung;
    int step, i;

    check(ls_world_def_init(&def, sizeof def));
    check(ls_world_create(&def, &world));
    ground = create_body(world, LS_BODY_STATIC, LS_SHAPE_BOX, 0, -0.5);
    body = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0, 0.6);
    hung = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0, -4.0);
    edit_body(world, body);
    edit_shape(world, first_shape(world, body));
    edit_compound(world, first_shape(world, hung));
    edit_joint(world, ground, hung);
    edit_world(world);

    /* A thousand edits between any two steps are welcome. */
    for (step = 0; step < 60; ++step) {
        for (i = 0; i < 1000; ++i) {
            const float push[3] = {0.0f, 0.001f, 0.0f};
            check(ls_body_impulse_add(world, body, push));
        }
        check(ls_world_step(world, 1.0f / 60.0f));
    }
    check(ls_world_destroy(world));
    printf("%d values were changed and came back\n", changes);
    return 0;
}
