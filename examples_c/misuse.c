/* What a host can do wrong, and the error it gets: nothing here is undefined, and nothing changes the world.
 *
 *     cc misuse.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o misuse && ./misuse
 *
 * Prints a line for each misuse; exits with 1 if one got another result than it should. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "longspan/longspan.h"

static int failures = 0;

static void expect(LsResult expected, LsResult result, const char *what)
{
    const int as_expected = result == expected;
    failures += !as_expected;
    printf("%-4s %-46s %-29s %s\n", as_expected ? "ok" : "BAD", what, ls_result_name_get(result),
           result == LS_OK ? "" : ls_last_error_message_get());
    if (!as_expected) {
        printf("     expected %s\n", ls_result_name_get(expected));
    }
}

static LsWorld create_world(void)
{
    LsWorldDef def;
    LsWorld world = {0};
    expect(LS_OK, ls_world_def_init(&def, sizeof def), "world definition");
    expect(LS_OK, ls_world_create(&def, &world), "world");
    return world;
}

static LsBody create_ball(LsWorld world, int kind, double y)
{
    LsShapeDef shape;
    LsBodyDef def;
    LsBody body = {0};
    ls_shape_def_init(&shape, sizeof shape);
    ls_body_def_init(&def, sizeof def);
    def.kind = kind;
    def.pose.position[1] = y;
    def.shapes = &shape;
    def.shape_count = 1;
    expect(LS_OK, ls_body_create(world, &def, &body), "body");
    return body;
}

static LsShape attach_ball(LsWorld world, LsBody body)
{
    LsShapeDef def;
    LsShape shape = {0};
    ls_shape_def_init(&def, sizeof def);
    expect(LS_OK, ls_shape_attach(world, body, &def, &shape), "shape");
    return shape;
}

/* The lower body hangs 2 m below the upper one. */
static LsJoint create_joint(LsWorld world, LsBody upper, LsBody lower)
{
    LsJointDef def;
    LsJoint joint = {0};
    ls_joint_def_init(&def, sizeof def);
    def.kind = LS_JOINT_SPHERICAL;
    def.body_a = upper;
    def.body_b = lower;
    def.frame_b.position[1] = 2.0;
    def.break_force = 1.0f;
    expect(LS_OK, ls_joint_create(world, &def, &joint), "joint");
    return joint;
}

static void worlds(void)
{
    LsWorld null = {0}, invented = {42}, dead = create_world();
    LsWorldDef def;
    expect(LS_OK, ls_world_destroy(dead), "destroy world");
    expect(LS_ERROR_NULL_HANDLE, ls_world_step(null, 0.01f), "null world");
    expect(LS_ERROR_INVALID_HANDLE, ls_world_step(invented, 0.01f), "invented world");
    expect(LS_ERROR_STALE_HANDLE, ls_world_step(dead, 0.01f), "stale world");
    expect(LS_ERROR_ALREADY_DESTROYED, ls_world_destroy(dead), "world destroyed twice");
    expect(LS_ERROR_NULL_HANDLE, ls_world_destroy(null), "destroy null world");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_create(NULL, &dead), "world definition is NULL");
    ls_world_def_init(&def, sizeof def);
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_create(&def, NULL), "place for the world is NULL");
    def.substeps = 0;
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_create(&def, &dead), "no substeps");
    ls_world_def_init(&def, sizeof def);
    def.gravity[1] = (float)NAN;
    expect(LS_ERROR_NOT_FINITE, ls_world_create(&def, &dead), "gravity is NaN");
    ls_world_def_init(&def, sizeof def);
    def.solver = 77;
    expect(LS_ERROR_INVALID_ENUM, ls_world_create(&def, &dead), "unknown solver");
}

static void bodies(LsWorld world, LsWorld other)
{
    LsBody body = create_ball(world, LS_BODY_DYNAMIC, 50.0), foreign = create_ball(other, LS_BODY_DYNAMIC, 0.0);
    LsBody null = {0}, invented = {0x123456789ABCDEF0u}, last_bit = body, list[2];
    LsPose pose, untouched;
    last_bit.id ^= 1u << 27;
    expect(LS_ERROR_NULL_HANDLE, ls_body_pose_get(world, null, &pose), "null body");
    expect(LS_ERROR_INVALID_HANDLE, ls_body_pose_get(world, invented, &pose), "invented body");
    expect(LS_ERROR_INVALID_HANDLE, ls_body_pose_get(world, last_bit, &pose), "body with a bit changed");
    expect(LS_ERROR_FOREIGN_HANDLE, ls_body_pose_get(world, foreign, &pose), "body of another world");
    list[0] = body;
    list[1] = foreign;
    memset(&pose, 0x55, sizeof pose);
    untouched = pose;
    expect(LS_ERROR_FOREIGN_HANDLE, ls_world_poses_get(world, list, 2, &pose), "bulk with a body of another world");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_poses_get(world, list, 2, NULL), "bulk to NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_poses_get(world, NULL, 2, &pose), "bulk from NULL");
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_poses_get(world, list, SIZE_MAX / 4, &pose), "bulk of more than memory holds");
    expect(LS_OK, memcmp(&pose, &untouched, sizeof pose) == 0 ? LS_OK : LS_ERROR_OTHER, "nothing was written");
    expect(LS_ERROR_NULL_ARGUMENT, ls_body_pose_get(world, body, NULL), "pose to NULL");
    expect(LS_OK, ls_body_destroy(world, body), "destroy body");
    expect(LS_ERROR_STALE_HANDLE, ls_body_pose_get(world, body, &pose), "stale body");
    expect(LS_ERROR_ALREADY_DESTROYED, ls_body_destroy(world, body), "body destroyed twice");
    (void)create_ball(world, LS_BODY_DYNAMIC, 60.0);
    expect(LS_ERROR_STALE_HANDLE, ls_body_wake(world, body), "stale body whose place is taken");
}

static void shapes_and_joints(LsWorld world, LsWorld other)
{
    LsBody upper = create_ball(world, LS_BODY_STATIC, 20.0), lower = create_ball(world, LS_BODY_DYNAMIC, 18.0);
    LsBody far_upper = create_ball(other, LS_BODY_STATIC, 20.0), far_lower = create_ball(other, LS_BODY_DYNAMIC, 18.0);
    LsShape shape = attach_ball(world, lower), foreign_shape = attach_ball(other, far_lower), no_shape = {0}, any_shape = {7};
    LsJoint joint = create_joint(world, upper, lower), foreign_joint = create_joint(other, far_upper, far_lower);
    LsJoint no_joint = {0}, any_joint = {7};
    LsJointDef def;
    LsJointAxisState axis;
    uint64_t word;

    expect(LS_ERROR_NULL_HANDLE, ls_shape_user_word_get(world, no_shape, &word), "null shape");
    expect(LS_ERROR_INVALID_HANDLE, ls_shape_user_word_get(world, any_shape, &word), "invented shape");
    expect(LS_ERROR_FOREIGN_HANDLE, ls_shape_user_word_get(world, foreign_shape, &word), "shape of another world");
    any_shape.id = lower.id;
    expect(LS_ERROR_INVALID_HANDLE, ls_shape_user_word_get(world, any_shape, &word), "a body's bits as a shape");
    expect(LS_OK, ls_shape_destroy(world, shape), "destroy shape");
    expect(LS_ERROR_STALE_HANDLE, ls_shape_user_word_get(world, shape, &word), "stale shape");
    expect(LS_ERROR_ALREADY_DESTROYED, ls_shape_destroy(world, shape), "shape destroyed twice");

    expect(LS_ERROR_NULL_HANDLE, ls_joint_break_set(world, no_joint, 1.0f, 1.0f), "null joint");
    expect(LS_ERROR_INVALID_HANDLE, ls_joint_break_set(world, any_joint, 1.0f, 1.0f), "invented joint");
    expect(LS_ERROR_FOREIGN_HANDLE, ls_joint_break_set(world, foreign_joint, 1.0f, 1.0f), "joint of another world");
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_break_set(world, joint, -1.0f, 1.0f), "negative break force");
    expect(LS_ERROR_NULL_HANDLE, ls_joint_friction_set(world, no_joint, 1.0f), "friction of a null joint");
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_friction_set(world, joint, -1.0f), "negative friction");
    expect(LS_ERROR_NOT_FINITE, ls_joint_friction_set(world, joint, INFINITY), "infinite friction");
    expect(LS_ERROR_NULL_ARGUMENT, ls_joint_axis_friction_set(world, joint, NULL), "friction of axes is NULL");
    expect(LS_ERROR_NULL_HANDLE, ls_joint_restitution_set(world, no_joint, 0.5f), "restitution of a null joint");
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_restitution_set(world, joint, -0.1f), "negative restitution of stops");
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_restitution_set(world, joint, 1.5f), "restitution of stops above 1");
    expect(LS_ERROR_NOT_FINITE, ls_joint_restitution_set(world, joint, NAN), "restitution of stops that is not a number");

    expect(LS_ERROR_NULL_HANDLE, ls_joint_axis_state_get(world, no_joint, 0, &axis, sizeof axis), "axis of a null joint");
    expect(LS_ERROR_INVALID_HANDLE, ls_joint_axis_state_get(world, any_joint, 0, &axis, sizeof axis), "axis of an invented joint");
    expect(LS_ERROR_FOREIGN_HANDLE, ls_joint_axis_state_get(world, foreign_joint, 0, &axis, sizeof axis), "axis of a foreign joint");
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_axis_state_get(world, joint, 2, &axis, sizeof axis), "third axis of a spherical joint");
    expect(LS_ERROR_NULL_ARGUMENT, ls_joint_axis_state_get(world, joint, 0, NULL, sizeof axis), "state of an axis is NULL");
    expect(LS_ERROR_STRUCT_SIZE, ls_joint_axis_state_get(world, joint, 0, &axis, 8), "state of an axis too small");
    expect(LS_OK, ls_joint_def_get(world, joint, &def, sizeof def), "definition of a joint");
    def.kind = LS_JOINT_HINGE;
    expect(LS_ERROR_NOT_APPLICABLE, ls_joint_kind_set(world, joint, &def), "turn a spherical joint into a hinge");
    def.limits.min = 1.0f;
    def.limits.max = -1.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_create(world, &def, &any_joint), "inverted limits");
    def.limits.max = 1.0f;
    def.motor.mode = -1;
    expect(LS_ERROR_INVALID_ENUM, ls_joint_create(world, &def, &any_joint), "unknown motor mode");
    def.motor.mode = LS_MOTOR_POSITION;
    def.motor_drive.side = 3;
    expect(LS_ERROR_INVALID_ENUM, ls_joint_create(world, &def, &any_joint), "unknown side of a motor");
    def.motor_drive.side = LS_FORCE_PULL;
    def.motor_drive.max_speed = -1.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_joint_create(world, &def, &any_joint), "negative greatest speed of a motor");
    def.motor_drive.max_speed = INFINITY;
    def.motor_drive.target_velocity = INFINITY;
    expect(LS_ERROR_NOT_FINITE, ls_joint_create(world, &def, &any_joint), "target that moves infinitely fast");
    def.motor_drive.target_velocity = 0.0f;
    def.motor_drive.side = LS_FORCE_BOTH;
    def.motor.mode = LS_MOTOR_OFF;
    def.kind = 6;
    expect(LS_ERROR_INVALID_ENUM, ls_joint_create(world, &def, &any_joint), "unknown joint kind");
    def.kind = LS_JOINT_FIXED;
    def.body_b = far_lower;
    expect(LS_ERROR_FOREIGN_HANDLE, ls_joint_create(world, &def, &any_joint), "joint to a body of another world");
    def.body_b = def.body_a;
    expect(LS_ERROR_NOT_APPLICABLE, ls_joint_create(world, &def, &any_joint), "joint of a body to itself");

    expect(LS_ERROR_NULL_ARGUMENT, ls_joint_frames_set(world, joint, NULL, NULL), "frames of a joint are NULL");
    expect(LS_ERROR_NULL_HANDLE, ls_joint_user_word_set(world, no_joint, 1), "word of a null joint");
    expect(LS_ERROR_NULL_ARGUMENT, ls_joint_user_word_get(world, joint, NULL), "word of a joint to NULL");
    expect(LS_OK, ls_joint_destroy(world, joint), "destroy joint");
    expect(LS_ERROR_STALE_HANDLE, ls_joint_break_set(world, joint, 1.0f, 1.0f), "stale joint");
    expect(LS_ERROR_ALREADY_DESTROYED, ls_joint_destroy(world, joint), "joint destroyed twice");
}

static void numbers(LsWorld world)
{
    LsBody body = create_ball(world, LS_BODY_DYNAMIC, 70.0), ground = create_ball(world, LS_BODY_STATIC, -50.0);
    float vector[3] = {0.0f, 0.0f, 0.0f};
    LsMass mass;
    LsPose pose;

    vector[1] = (float)NAN;
    expect(LS_ERROR_NOT_FINITE, ls_body_linear_velocity_set(world, body, vector), "velocity is NaN");
    expect(LS_ERROR_NOT_FINITE, ls_body_force_add(world, body, vector), "force is NaN");
    vector[1] = (float)INFINITY;
    expect(LS_ERROR_NOT_FINITE, ls_world_gravity_set(world, vector), "gravity is infinite");
    vector[1] = 1.0e5f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_body_linear_velocity_set(world, body, vector), "velocity is too great");
    expect(LS_ERROR_NOT_APPLICABLE, ls_body_force_add(world, ground, vector), "force on a static body");
    expect(LS_ERROR_NULL_ARGUMENT, ls_body_force_add(world, body, NULL), "force is NULL");

    mass.kind = LS_MASS_TOTAL;
    mass.properties.mass = 0.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_body_mass_set(world, body, &mass), "mass is zero");
    mass.properties.mass = -1.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_body_mass_set(world, body, &mass), "mass is negative");
    mass.properties.mass = (float)NAN;
    expect(LS_ERROR_NOT_FINITE, ls_body_mass_set(world, body, &mass), "mass is NaN");
    mass.kind = 9;
    expect(LS_ERROR_INVALID_ENUM, ls_body_mass_set(world, body, &mass), "unknown mass kind");
    expect(LS_ERROR_NOT_APPLICABLE, ls_body_mass_get(world, ground, &mass.properties), "mass of a static body");

    expect(LS_OK, ls_body_pose_get(world, body, &pose), "pose");
    pose.rotation[3] = 1.1f;
    expect(LS_ERROR_NOT_UNIT, ls_body_pose_set(world, body, &pose), "rotation is 10 % too long");
    pose.rotation[3] = 1.0f;
    pose.position[0] = (double)INFINITY;
    expect(LS_ERROR_NOT_FINITE, ls_body_pose_set(world, body, &pose), "position is infinite");
    pose.position[0] = 1.0e10;
    expect(LS_ERROR_OUT_OF_RANGE, ls_body_pose_set(world, body, &pose), "position is too far away");
    pose.position[0] = 0.0;
    expect(LS_ERROR_NOT_APPLICABLE, ls_body_move_to(world, body, &pose), "target for a dynamic body");
    expect(LS_ERROR_INVALID_ENUM, ls_body_locked_axes_set(world, body, 64), "unknown locked axis");
    expect(LS_ERROR_OUT_OF_RANGE, ls_body_damping_set(world, body, -1.0f, 0.0f), "damping is negative");
    expect(LS_ERROR_NULL_ARGUMENT, ls_body_damping_get(world, body, vector, NULL), "damping to NULL");
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_effort_set(world, 4, 257), "too many sweeps");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_sleep_settings_set(world, NULL), "sleep settings are NULL");
    expect(LS_ERROR_NOT_FINITE, ls_world_restitution_threshold_set(world, (float)NAN), "restitution threshold is NaN");
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_step(world, 0.0f), "step of no time");
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_step(world, -0.01f), "step backwards");
    expect(LS_ERROR_NOT_FINITE, ls_world_step(world, (float)NAN), "step of NaN");
    expect(LS_ERROR_INVALID_ENUM, ls_log_callback_set(NULL, 12, NULL), "unknown log level");
}

static void shape_definitions(LsWorld world)
{
    static const float line[15] = {0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4};
    static const float square[12] = {0, 0, 0, 1, 0, 0, 1, 0, 1, 0, 0, 1};
    static const float heights[6] = {0, 0, 0, 0, 0, 0};
    static const uint32_t triangles[6] = {0, 2, 1, 0, 3, 4};
    LsBody body = create_ball(world, LS_BODY_STATIC, -80.0), heavy = create_ball(world, LS_BODY_DYNAMIC, 80.0);
    LsShapeDef def, part;
    LsShape shape = {0};

    ls_shape_def_init(&def, sizeof def);
    def.kind = 10;
    expect(LS_ERROR_INVALID_ENUM, ls_shape_attach(world, body, &def, &shape), "unknown shape kind");
    def.kind = LS_SHAPE_BALL;
    def.radius = -1.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_shape_attach(world, body, &def, &shape), "radius is negative");
    def.kind = LS_SHAPE_BOX;
    def.half_extents[2] = 0.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_shape_attach(world, body, &def, &shape), "box without depth");
    def.kind = LS_SHAPE_HALF_SPACE;
    def.normal[1] = 2.0f;
    expect(LS_ERROR_NOT_UNIT, ls_shape_attach(world, body, &def, &shape), "normal is not a unit vector");
    def.normal[1] = 1.0f;
    expect(LS_ERROR_NOT_APPLICABLE, ls_shape_attach(world, heavy, &def, &shape), "half-space on a dynamic body");

    def.kind = LS_SHAPE_CONVEX_HULL;
    def.points = line;
    def.point_count = 5;
    expect(LS_ERROR_DEGENERATE, ls_shape_attach(world, body, &def, &shape), "hull of points on a line");
    def.points = square;
    def.point_count = 4;
    expect(LS_ERROR_DEGENERATE, ls_shape_attach(world, body, &def, &shape), "hull of points in a plane");
    def.points = NULL;
    expect(LS_ERROR_NULL_ARGUMENT, ls_shape_attach(world, body, &def, &shape), "points are NULL");
    def.points = line;
    def.point_count = SIZE_MAX / 2;
    expect(LS_ERROR_OUT_OF_RANGE, ls_shape_attach(world, body, &def, &shape), "more points than memory holds");

    def.kind = LS_SHAPE_TRIANGLE_MESH;
    def.points = square;
    def.point_count = 4;
    def.triangles = triangles;
    def.triangle_count = 2;
    expect(LS_ERROR_INDEX_OUT_OF_RANGE, ls_shape_attach(world, body, &def, &shape), "triangle with a fifth of four points");

    def.kind = LS_SHAPE_HEIGHT_FIELD;
    def.heights = heights;
    def.height_count = 6;
    def.rows = 3;
    def.columns = 3;
    expect(LS_ERROR_INDEX_OUT_OF_RANGE, ls_shape_attach(world, body, &def, &shape), "six heights for nine");
    def.rows = def.columns = 0xFFFFFFFFu;
    expect(LS_ERROR_INDEX_OUT_OF_RANGE, ls_shape_attach(world, body, &def, &shape), "rows times columns too great");

    ls_shape_def_init(&part, sizeof part);
    def.kind = LS_SHAPE_COMPOUND;
    def.parts = &def;
    def.part_count = 1;
    expect(LS_ERROR_NOT_APPLICABLE, ls_shape_attach(world, body, &def, &shape), "compound that contains itself");
    def.parts = &part;
    part.struct_size = 0;
    expect(LS_ERROR_STRUCT_SIZE, ls_shape_attach(world, body, &def, &shape), "part that was not initialised");
    part.struct_size = sizeof part;
    part.local_rotation[3] = 0.0f;
    expect(LS_ERROR_NOT_UNIT, ls_shape_attach(world, body, &def, &shape), "part without a rotation");
    def.kind = LS_SHAPE_BALL;
    def.radius = 0.5f;
    def.material.friction_rule = 5;
    expect(LS_ERROR_INVALID_ENUM, ls_shape_attach(world, body, &def, &shape), "unknown combine rule");
    expect(LS_OK, shape.id == 0 ? LS_OK : LS_ERROR_OTHER, "no shape was made");
    expect(LS_ERROR_NULL_HANDLE, ls_shape_def_set(world, shape, &part), "definition for a null shape");
    shape = attach_ball(world, heavy);
    expect(LS_ERROR_NOT_UNIT, ls_shape_def_set(world, shape, &part), "new definition without a rotation");
    expect(LS_ERROR_NOT_APPLICABLE, ls_shape_part_get(world, shape, 0, &part, sizeof part), "part of a ball");
    ls_shape_def_init(&part, sizeof part);
    part.kind = LS_SHAPE_HALF_SPACE;
    expect(LS_ERROR_NOT_APPLICABLE, ls_shape_def_set(world, shape, &part), "a dynamic body's ball becomes a half-space");
    expect(LS_ERROR_STRUCT_SIZE, ls_shape_def_get(world, shape, &part, 1), "definition of a shape to one byte");
}

static void queries(LsWorld world)
{
    LsRay ray = {{0, 0, 0}, {1, 0, 0}, 1};
    LsQueryFilter filter;
    LsRayHit hit;
    LsShapeDef shape;
    LsPose pose = {{0, 0, 0}, {0, 0, 0, 1}};
    LsNearestPoint nearest;
    LsShapeDistance distance;
    LsCastDef cast;
    LsCastHit met;
    const LsShape none = {0};
    const double corners[6] = {1, 1, 1, 0, 0, 0};
    float path[3] = {1, 0, 0};
    size_t count;

    expect(LS_ERROR_NULL_ARGUMENT, ls_world_ray_cast(world, NULL, NULL, &hit), "ray is NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_ray_cast(world, &ray, NULL, NULL), "hit to NULL");
    ray.direction[0] = 2.0f;
    expect(LS_ERROR_NOT_UNIT, ls_world_ray_cast(world, &ray, NULL, &hit), "direction of a ray is not a unit vector");
    ray.direction[0] = 1.0f;
    ray.length = -1.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_rays_cast(world, &ray, 1, NULL, &hit), "ray of negative length");
    ray.length = (float)NAN;
    expect(LS_ERROR_NOT_FINITE, ls_world_ray_cast_all(world, &ray, NULL, NULL, 0, &count), "ray of no known length");
    ray.length = 1.0f;
    memset(&filter, 0, sizeof filter);
    expect(LS_ERROR_STRUCT_SIZE, ls_world_ray_cast(world, &ray, &filter, &hit), "filter filled with zeros");
    ls_query_filter_init(&filter, sizeof filter);
    filter.kinds = 8;
    expect(LS_ERROR_INVALID_ENUM, ls_world_ray_cast(world, &ray, &filter, &hit), "unknown kind of body in a filter");
    filter.kinds = LS_QUERY_STATIC;
    filter.ignored_count = 2;
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_ray_cast(world, &ray, &filter, &hit), "two ignored bodies at NULL");
    ls_shape_def_init(&shape, sizeof shape);
    shape.kind = LS_SHAPE_HALF_SPACE;
    expect(LS_ERROR_NOT_APPLICABLE, ls_world_shape_cast(world, &shape, &pose, path, NULL, &hit), "sweep of a half-space");
    shape.kind = LS_SHAPE_BALL;
    path[0] = 1.0e8f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_shape_cast(world, &shape, &pose, path, NULL, &hit), "sweep too long");
    pose.rotation[3] = 0.0f;
    expect(LS_ERROR_NOT_UNIT, ls_world_shape_overlaps_get(world, &shape, &pose, NULL, NULL, 0, &count), "overlap without a rotation");
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_box_overlaps_get(world, corners, corners + 3, NULL, NULL, 0, &count), "box inside out");
    expect(LS_ERROR_NOT_UNIT, ls_world_nearest_shape_get(world, &shape, &pose, 1.0f, NULL, &distance), "nearest to a solid without a rotation");
    pose.rotation[3] = 1.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_nearest_shape_get(world, &shape, &pose, -1.0f, NULL, &distance), "nearest within less than nothing");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_nearest_shape_get(world, &shape, &pose, 1.0f, NULL, NULL), "nearest shape to NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_nearest_shape_get(world, NULL, &pose, 1.0f, NULL, &distance), "nearest to no solid");
    expect(LS_ERROR_NULL_HANDLE, ls_world_shape_distance_get(world, none, none, &distance), "distance between null shapes");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_shape_distance_get(world, none, none, NULL), "distance to NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_cast_def_init(NULL, sizeof cast), "cast definition is NULL");
    memset(&cast, 0, sizeof cast);
    expect(LS_ERROR_STRUCT_SIZE, ls_world_cast(world, &cast, NULL, &met), "cast filled with zeros");
    ls_cast_def_init(&cast, sizeof cast);
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_cast(world, NULL, NULL, &met), "cast is NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_cast(world, &cast, NULL, NULL), "hit of a cast to NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_cast_all(world, &cast, NULL, NULL, 0, NULL), "number of hits to NULL");
    cast.path[1] = NAN;
    expect(LS_ERROR_NOT_FINITE, ls_world_cast(world, &cast, NULL, &met), "cast along no known path");
    cast.path[1] = 1.0e8;
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_cast_all(world, &cast, NULL, &met, 1, &count), "cast too long");
    cast.path[1] = 1.0;
    cast.turn[0] = 1000.0f;
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_cast(world, &cast, NULL, &met), "cast that turns too often");
    cast.turn[0] = 0.0f;
    shape.kind = LS_SHAPE_HALF_SPACE;
    cast.shape = &shape;
    expect(LS_ERROR_NOT_APPLICABLE, ls_world_cast(world, &cast, NULL, &met), "cast of a half-space");
    expect(LS_ERROR_OUT_OF_RANGE, ls_world_nearest_point_get(world, corners, -1.0f, NULL, &nearest), "negative distance");
}

static void sizes(LsWorld world)
{
    LsBodyDef def;
    LsBody body = {0};
    LsStepReport report;
    size_t count = 0;

    expect(LS_ERROR_STRUCT_SIZE, ls_body_def_init(&def, 3), "definition smaller than any version");
    expect(LS_ERROR_NULL_ARGUMENT, ls_body_def_init(NULL, sizeof def), "definition is NULL");
    memset(&def, 0, sizeof def);
    expect(LS_ERROR_STRUCT_SIZE, ls_body_create(world, &def, &body), "definition filled with zeros");
    memset(&def, 0xEE, sizeof def);
    expect(LS_ERROR_STRUCT_SIZE, ls_body_create(world, &def, &body), "definition filled with garbage");
    ls_body_def_init(&def, sizeof def);
    def.kind = 3;
    expect(LS_ERROR_INVALID_ENUM, ls_body_create(world, &def, &body), "unknown body kind");
    def.kind = LS_BODY_DYNAMIC;
    expect(LS_ERROR_OUT_OF_RANGE, ls_body_create(world, &def, &body), "dynamic body without shape or mass");
    def.shape_count = 1;
    expect(LS_ERROR_NULL_ARGUMENT, ls_body_create(world, &def, &body), "one shape at NULL");
    expect(LS_ERROR_STRUCT_SIZE, ls_world_report_get(world, &report, 0), "report of no size");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_report_get(world, NULL, sizeof report), "report to NULL");
    expect(LS_ERROR_BUFFER_TOO_SMALL, ls_world_bodies_get(world, NULL, 0, &count), "no room for bodies");
    expect(LS_OK, count > 1 ? LS_OK : LS_ERROR_OTHER, "but their number is known");
    expect(LS_ERROR_BUFFER_TOO_SMALL, ls_world_bodies_get(world, &body, 1, &count), "room for one body");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_bodies_get(world, NULL, 1, &count), "room at NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_bodies_get(world, &body, 1, NULL), "place for the number is NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_moved_bodies_get(world, NULL, &count), "place for an array is NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_islands_get(world, NULL, &count), "place for islands is NULL");
    expect(LS_ERROR_BUFFER_TOO_SMALL, ls_world_save(world, &def, sizeof def, &count), "no room for a snapshot");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_save(world, NULL, 1, &count), "room for a snapshot at NULL");
    expect(LS_ERROR_NULL_ARGUMENT, ls_world_restore(world, NULL, 1), "snapshot is NULL");
    expect(LS_ERROR_INVALID_SNAPSHOT, ls_world_restore(world, &def, sizeof def), "something else as a snapshot");
    expect(LS_ERROR_INVALID_SNAPSHOT, ls_world_restore(world, &def, 0), "nothing as a snapshot");
}

/* A callback must not change its world: it gets an error, not a deadlock. Reading is fine. */
static void on_overload(LsWorld world, const LsJointOverload *overload, void *user)
{
    LsJointState state;
    ++*(int *)user;
    expect(LS_OK, ls_joint_state_get(world, overload->joint, &state, sizeof state), "reading inside a callback");
    expect(LS_ERROR_WORLD_LOCKED, ls_joint_destroy(world, overload->joint), "editing inside a callback");
    expect(LS_ERROR_WORLD_LOCKED, ls_world_step(world, 0.01f), "stepping inside a callback");
    expect(LS_ERROR_WORLD_LOCKED, ls_world_destroy(world), "destroying inside a callback");
}

static void on_log(int32_t level, const char *message, void *user)
{
    const LsWorld world = *(const LsWorld *)user;
    (void)message;
    expect(LS_ERROR_WORLD_LOCKED, level == LS_LOG_WARNING ? ls_world_step(world, 0.01f) : LS_OK, "stepping inside a log callback");
}

static void callbacks(void)
{
    LsWorld world = create_world();
    LsBody upper = create_ball(world, LS_BODY_STATIC, 0.0), lower = create_ball(world, LS_BODY_DYNAMIC, -2.0);
    LsBody null = {0};
    LsJoint joint = create_joint(world, upper, lower);
    int calls = 0;
    expect(LS_OK, ls_world_overload_callback_set(world, on_overload, &calls), "set a callback");
    expect(LS_OK, ls_world_step(world, 1.0f / 60.0f), "step");
    expect(LS_OK, calls == 1 ? LS_OK : LS_ERROR_OTHER, "the callback ran once");
    expect(LS_OK, ls_joint_destroy(world, joint), "editing after the step");
    expect(LS_OK, ls_log_callback_set(on_log, LS_LOG_WARNING, &world), "set a log callback");
    expect(LS_ERROR_NULL_HANDLE, ls_body_wake(world, null), "a refused call with a log callback");
    expect(LS_OK, ls_log_callback_set(NULL, LS_LOG_OFF, NULL), "unset the log callback");
    expect(LS_OK, ls_world_destroy(world), "destroy world");
}

int main(void)
{
    LsWorld world = create_world(), other = create_world();
    worlds();
    bodies(world, other);
    shapes_and_joints(world, other);
    numbers(world);
    shape_definitions(world);
    queries(world);
    sizes(world);
    callbacks();
    expect(LS_OK, ls_world_step(world, 1.0f / 60.0f), "after all that the world still steps");
    expect(LS_OK, ls_world_destroy(world), "destroy world");
    expect(LS_OK, ls_world_destroy(other), "destroy world");
    printf("%d unexpected\n", failures);
    return failures == 0 ? 0 : 1;
}
