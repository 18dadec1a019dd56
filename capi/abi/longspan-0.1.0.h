/* longspan: rigid-body physics for things that hang, span and stand.
 *
 * This file is generated from the comments and declarations of the library; do not edit it.
 *
 * Conventions
 *   Units are SI: metres, kilograms, seconds, newtons, radians. Axes are right-handed; gravity is a vector.
 *   Positions are doubles, everything else is float. A vector is three numbers x, y, z, a rotation four: x, y, z, w.
 *   Every call returns LS_OK or an LS_ERROR_ code; results come through pointers. A call that fails has changed nothing and
 *   has written nothing, unless it says otherwise. ls_last_error_message_get tells which argument was at fault, and why.
 *
 * Handles
 *   64 bits, passed by value; all zero is null. Any bit pattern is safe to pass: null, stale, foreign and invented handles and
 *   those of destroyed objects have an error each. "A world error" below means LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE or
 *   LS_ERROR_STALE_HANDLE about the world, LS_ERROR_WORLD_BUSY, LS_ERROR_WORLD_POISONED, and for edits LS_ERROR_WORLD_LOCKED.
 *   "A handle error" means LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE or LS_ERROR_FOREIGN_HANDLE.
 *
 * Pointers
 *   Pointers must be NULL or valid for what is said of them, during the call; that is the host's duty. NULL is refused where
 *   something is needed. No array of the host is kept after the call.
 *
 * Structs that grow
 *   Definitions begin with struct_size. Fill them with their _init function, which takes sizeof of the struct as the host knows
 *   it, and then change what is wanted: so an old host runs on a new library, and a new one on an old library. Structs that the
 *   library fills and that may grow come with a size argument. All other structs keep their layout for ever. On and off are
 *   uint32_t: 0 is off, anything else is on. This header is for platforms with 64-bit pointers.
 *
 * Threads
 *   Calls on different worlds never disturb each other. A call on a world that another thread is using at that moment gets:
 *
 *              during a read          during an edit         during a step          during the step's callbacks
 *     read     LS_OK                  LS_ERROR_WORLD_BUSY    LS_ERROR_WORLD_BUSY    LS_OK
 *     edit     LS_ERROR_WORLD_BUSY    LS_ERROR_WORLD_BUSY    LS_ERROR_WORLD_BUSY    LS_ERROR_WORLD_BUSY
 *
 *   No call waits for another. "Threads: read" or "Threads: edit" at each function says what it is; stepping and destroying are
 *   edits. A step uses threads of its own if the world was made with more than one. Handles and arrays may be passed between
 *   threads.
 *
 * Callbacks
 *   Run on the thread whose call causes them, those of a step after its solve, in an order that does not depend on threads.
 *   Inside one, reads work, and edits of the world return LS_ERROR_WORLD_LOCKED ("Callbacks:" at each function).
 *
 * Failures inside the library
 *   None crosses into the host. A call, whichever it is, during which the library fails returns LS_ERROR_PANIC (the Rust runtime may also print
 *   a line on the error stream); its world is then poisoned: it returns LS_ERROR_WORLD_POISONED and can only be destroyed.
 *
 * Floating-point settings
 *   Flush-to-zero, rounding and traps of the host's thread are set aside at each call and restored when it returns; callbacks run
 *   under the host's own.
 */


#ifndef LONGSPAN_H
#define LONGSPAN_H

#include <stddef.h>
#include <stdint.h>

/** Major version of this header. */
#define LS_VERSION_MAJOR 0

/** Minor version of this header. */
#define LS_VERSION_MINOR 1

/** Patch version of this header. */
#define LS_VERSION_PATCH 0

/**
 * Number of the binary interface that this header describes; it is also the number in the SONAME. A library with the same
 * number runs every host compiled against an older or newer header with that number.
 */
#define LS_ABI_VERSION 0

/** Log level: nothing. */
#define LS_LOG_OFF 0

/** Log level: the library itself failed; a world is poisoned. */
#define LS_LOG_ERROR 1

/** Log level: a call was refused, or a body was quarantined. */
#define LS_LOG_WARNING 2

/** Shape kind: a ball; radius. */
#define LS_SHAPE_BALL 0

/** Shape kind: a box; half_extents. */
#define LS_SHAPE_BOX 1

/** Shape kind: a cylinder along y with hemispheres at its ends; half_height of the cylinder, radius. */
#define LS_SHAPE_CAPSULE 2

/** Shape kind: a cylinder along y; half_height, radius. */
#define LS_SHAPE_CYLINDER 3

/** Shape kind: a cone along y, tip up, with its origin halfway up; half_height, radius of the base. */
#define LS_SHAPE_CONE 4

/** Shape kind: the convex hull of 4 to 4096 points that are not all in one plane; points. */
#define LS_SHAPE_CONVEX_HULL 5

/** Shape kind: triangles, for static and kinematic bodies only; points, triangles. */
#define LS_SHAPE_TRIANGLE_MESH 6

/**
 * Shape kind: heights on a grid, centred on the origin, for static and kinematic bodies only; heights, rows, columns,
 * size_x, size_z.
 */
#define LS_SHAPE_HEIGHT_FIELD 7

/** Shape kind: all points below a plane through the origin, for static and kinematic bodies only; normal. */
#define LS_SHAPE_HALF_SPACE 8

/** Shape kind: several convex shapes as one, with one material; parts. */
#define LS_SHAPE_COMPOUND 9

/** Combine rule: square root of the product. Where two touching shapes have different rules, the greater number wins. */
#define LS_COMBINE_GEOMETRIC_MEAN 0

/** Combine rule: arithmetic mean. */
#define LS_COMBINE_AVERAGE 1

/** Combine rule: the smaller value. */
#define LS_COMBINE_MINIMUM 2

/** Combine rule: the product. */
#define LS_COMBINE_MULTIPLY 3

/** Combine rule: the greater value. */
#define LS_COMBINE_MAXIMUM 4

/** Body kind: never moves. */
#define LS_BODY_STATIC 0

/** Body kind: moves as the host says, by velocity or target pose, and pushes dynamic bodies without being pushed. */
#define LS_BODY_KINEMATIC 1

/** Body kind: moves by forces, contacts and joints. */
#define LS_BODY_DYNAMIC 2

/** Mass kind: volume times density of the shapes. */
#define LS_MASS_FROM_SHAPES 0

/** Mass kind: properties.mass, distributed as the shapes say. */
#define LS_MASS_TOTAL 1

/** Mass kind: properties, whatever the shapes are. */
#define LS_MASS_PROPERTIES 2

/** Locked axis: no translation along the world's x axis. */
#define LS_LOCK_TRANSLATION_X 1

/** Locked axis: no translation along the world's y axis. */
#define LS_LOCK_TRANSLATION_Y 2

/** Locked axis: no translation along the world's z axis. */
#define LS_LOCK_TRANSLATION_Z 4

/** Locked axis: no rotation about the world's x axis. */
#define LS_LOCK_ROTATION_X 8

/** Locked axis: no rotation about the world's y axis. */
#define LS_LOCK_ROTATION_Y 16

/** Locked axis: no rotation about the world's z axis. */
#define LS_LOCK_ROTATION_Z 32

/** Joint kind: nothing moves. */
#define LS_JOINT_FIXED 0

/** Joint kind: rotation about the joint axis, the angle in (-pi, pi]; limits, motor. */
#define LS_JOINT_HINGE 1

/** Joint kind: rotation about a point; swing_limit, limits (of the twist), spherical_motor. */
#define LS_JOINT_SPHERICAL 2

/** Joint kind: the distance between two points; limits, has_spring, spring_length, motor. */
#define LS_JOINT_DISTANCE 3

/** Joint kind: translation along the joint axis; limits, motor. */
#define LS_JOINT_PRISMATIC 4

/**
 * Joint kind: six axes of A's frame, each free, locked or limited; linear_axes, angular_axes. Rotations are x, y, z Euler
 * angles of B's frame in A's; keep the one about y within 80 degrees unless both others are locked.
 */
#define LS_JOINT_GENERIC 5

/** Motor mode: nothing drives the coordinate. */
#define LS_MOTOR_OFF 0

/** Motor mode: holds a speed with at most the greatest force or torque. */
#define LS_MOTOR_VELOCITY 1

/** Motor mode: pulls towards a value as a spring and damper, with at most the greatest force or torque. */
#define LS_MOTOR_POSITION 2

/** Solver: the library chooses per group of bodies. */
#define LS_SOLVER_AUTO 0

/** Solver: sweeps over the constraints, with long-range constraints. */
#define LS_SOLVER_GAUSS_SEIDEL 1

/** Solver: direct solve of articulations; LS_ERROR_UNSUPPORTED in this version. */
#define LS_SOLVER_DIRECT 2

/**
 * What a call returns: LS_OK, or one of the LS_ERROR_ constants. Unless a function says otherwise, a call that fails has
 * changed nothing and has written nothing through its pointers. New codes may be added: treat an unknown one as a failure.
 */
typedef int32_t LsResult;

/** Version of a library. */
typedef struct LsVersion {
    /** Major version. */
    uint32_t major;
    /** Minor version. */
    uint32_t minor;
    /** Patch version. */
    uint32_t patch;
    /** Number of the binary interface, to be compared with LS_ABI_VERSION. */
    uint32_t abi;
} LsVersion;

/**
 * Receives log messages.
 *
 * Called on the thread whose call has something to say, under the host's floating-point settings. It must return normally
 * (no exception, no longjmp). Inside it, reads work if the world allows them, edits of any world return
 * LS_ERROR_WORLD_LOCKED, and what those calls have to say is not logged.
 * @param level    LS_LOG_ERROR or LS_LOG_WARNING
 * @param message  UTF-8, valid during the call
 * @param user     as given to ls_log_callback_set
 */
typedef void (*LsLogCallback)(int32_t level, const char *message, void *user);

/** Surface of a shape. */
typedef struct LsMaterial {
    /** Coulomb friction coefficient, >= 0; default 0.5. */
    float friction;
    /** Rebound speed over approach speed, 0 to 1; default 0. Used above the world's restitution_threshold. */
    float restitution;
    /** Rolling friction: torque limit about tangent axes per normal force (m), >= 0; default 0. Of two shapes the greater counts. */
    float rolling_friction;
    /**
     * Spinning friction: torque limit about the normal per normal force (m), >= 0, beside that of the contact's own extent;
     * default 0. Of two shapes the greater counts.
     */
    float spinning_friction;
    /** LS_COMBINE_ constant: how friction combines; default LS_COMBINE_GEOMETRIC_MEAN. */
    int32_t friction_rule;
    /** LS_COMBINE_ constant: how restitution combines; default LS_COMBINE_MAXIMUM. */
    int32_t restitution_rule;
} LsMaterial;

/** Which shapes a shape collides with: two collide if each one's member_of meets the other's collides_with. */
typedef struct LsCollisionFilter {
    /** Bit set of groups this shape belongs to; default 1. */
    uint32_t member_of;
    /** Bit set of groups this shape collides with; default all. */
    uint32_t collides_with;
} LsCollisionFilter;

/**
 * A shape: form, place on its body, surface, density. Of the geometry fields only those are read that its kind names.
 *
 * Fill it with ls_shape_def_init first. Arrays are read during the call that takes the definition and not kept.
 */
typedef struct LsShapeDef {
    /** Size of this struct in the host, set by ls_shape_def_init. */
    uint32_t struct_size;
    /** LS_SHAPE_ constant; default LS_SHAPE_BALL. */
    int32_t kind;
    /** Half of each edge of a box (m), 1e-5 to 1e6; default 0.5. */
    float half_extents[3];
    /** Half the height of a capsule's cylinder, a cylinder or a cone (m), 1e-5 to 1e6; default 0.5. */
    float half_height;
    /** Radius of a ball, capsule, cylinder or cone (m), 1e-5 to 1e6; default 0.5. */
    float radius;
    /** Outward unit normal of a half-space; default +y. */
    float normal[3];
    /** Points of a hull or vertices of a mesh (m): three floats each. */
    const float *points;
    /** Number of points. */
    size_t point_count;
    /** Triangles of a mesh: three indices of points each, counter-clockwise seen from outside. */
    const uint32_t *triangles;
    /** Number of triangles. */
    size_t triangle_count;
    /** Heights of a height field along y (m), row by row. */
    const float *heights;
    /** Number of heights; must be rows x columns. */
    size_t height_count;
    /** Rows of a height field, along z; at least 2. */
    uint32_t rows;
    /** Columns of a height field, along x; at least 2. */
    uint32_t columns;
    /** Extent of a whole height field along x (m); default 1. */
    float size_x;
    /** Extent of a whole height field along z (m); default 1. */
    float size_z;
    /** Parts of a compound, all with the same struct_size; of each, its geometry, local_position and local_rotation are read. */
    const struct LsShapeDef *parts;
    /** Number of parts. */
    size_t part_count;
    /** Origin of the shape in the body's frame (m); default zero. */
    float local_position[3];
    /** Rotation of the shape in the body's frame, unit quaternion x, y, z, w; default none. */
    float local_rotation[4];
    /** Density (kg/m^3), >= 0; gives the body its mass unless that is set outright; default 1000. */
    float density;
    /** Surface. */
    struct LsMaterial material;
    /** Which other shapes it collides with. */
    struct LsCollisionFilter filter;
    /** The host's own word; the library only hands it back. */
    uint64_t user_word;
} LsShapeDef;

/** Where something is: position in double, rotation in float precision. */
typedef struct LsPose {
    /** Origin of the frame (m); at most 1e9 m from that of the world. */
    double position[3];
    /** Rotation of the frame, unit quaternion x, y, z, w; up to 1 % off unit length is normalised, more is refused. */
    float rotation[4];
} LsPose;

/** Mass properties of a rigid body, in its own frame. */
typedef struct LsMassProperties {
    /** Mass (kg), 1e-9 to 1e12. */
    float mass;
    /** Centre of mass (m). */
    float center_of_mass[3];
    /** Principal moments of inertia about the centre of mass (kg m^2), each > 0. */
    float principal_inertia[3];
    /** Rotation of the principal axes, unit quaternion x, y, z, w. */
    float inertia_frame[4];
} LsMassProperties;

/** Where a dynamic body's mass comes from. */
typedef struct LsMass {
    /** LS_MASS_ constant; default LS_MASS_FROM_SHAPES. */
    int32_t kind;
    /** Read as far as the kind names it; default 1 kg, 1 kg m^2, centred, not rotated. */
    struct LsMassProperties properties;
} LsMass;

/** Everything a body starts with. Fill it with ls_body_def_init first. Arrays are read during the call and not kept. */
typedef struct LsBodyDef {
    /** Size of this struct in the host, set by ls_body_def_init. */
    uint32_t struct_size;
    /** LS_BODY_ constant; default LS_BODY_DYNAMIC. */
    int32_t kind;
    /** Its frame in the world; default the world's own. */
    struct LsPose pose;
    /** Velocity of its centre of mass (m/s), at most 1e4; default zero. */
    float linear_velocity[3];
    /** Angular velocity, world axes (rad/s), at most 1e4; default zero. */
    float angular_velocity[3];
    /** Where its mass comes from. A dynamic body needs a shape with density, or LS_MASS_PROPERTIES. */
    struct LsMass mass;
    /** Rate at which linear velocity decays (1/s), >= 0; default 0. */
    float linear_damping;
    /** Rate at which angular velocity decays (1/s), >= 0; default 0. */
    float angular_damping;
    /** Factor on the world's gravity; default 1. */
    float gravity_scale;
    /** Bit set of LS_LOCK_ constants: degrees of freedom taken away; default 0. */
    uint32_t locked_axes;
    /** Not 0: it may fall asleep; default 1. */
    uint32_t can_sleep;
    /** Not 0: it is swept through the step, so that it cannot tunnel through anything thin; default 0. */
    uint32_t fast;
    /** The host's own word; the library only hands it back. */
    uint64_t user_word;
    /** Shapes it is made with, all with the same struct_size; more can be attached later. Default none. */
    const struct LsShapeDef *shapes;
    /** Number of shapes. */
    size_t shape_count;
} LsBodyDef;

/** Names a body of one world. Passed by value; any value is safe. */
typedef struct LsBody {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsBody;

/** Give of constraint rows. Acts as a physical spring and damper whatever the number of substeps and iterations. */
typedef struct LsSoftness {
    /** Inverse stiffness (m/N or rad/(N m)), >= 0; 0 is rigid. */
    float compliance;
    /** Force per relative speed (N s/m or N m s/rad), >= 0; without compliance there is nothing to damp. */
    float damping;
} LsSoftness;

/** Least and greatest value of a coordinate (m or rad); -INFINITY and INFINITY for none. Equal values lock it there. */
typedef struct LsLimits {
    /** Least value. */
    float min;
    /** Greatest value. */
    float max;
} LsLimits;

/** What drives one coordinate of a joint. */
typedef struct LsMotor {
    /** LS_MOTOR_ constant. */
    int32_t mode;
    /** Speed (m/s or rad/s) or value (m or rad) to reach. */
    float target;
    /** Spring and damper of LS_MOTOR_POSITION; rigid reaches the target as fast as max_force allows. */
    struct LsSoftness softness;
    /** Greatest force (N) or torque (N m), may be INFINITY. */
    float max_force;
} LsMotor;

/** What drives the rotation of a spherical joint. */
typedef struct LsSphericalMotor {
    /** LS_MOTOR_ constant. */
    int32_t mode;
    /** LS_MOTOR_VELOCITY: angular velocity of B against A, in A's joint frame (rad/s). */
    float target_velocity[3];
    /** LS_MOTOR_POSITION: rotation of B's joint frame in A's, unit quaternion x, y, z, w. */
    float target_rotation[4];
    /** Spring and damper of LS_MOTOR_POSITION. */
    struct LsSoftness softness;
    /** Greatest torque (N m), may be INFINITY. */
    float max_torque;
} LsSphericalMotor;

/** One coordinate of a generic joint. */
typedef struct LsAxis {
    /** Range of the coordinate (m or rad). */
    struct LsLimits limits;
    /** Drive of the coordinate. */
    struct LsMotor motor;
} LsAxis;

/**
 * Everything a joint starts with. Fill it with ls_joint_def_init first.
 *
 * A joint ties a frame on body A to a frame on body B. The joint axis is the x axis of both frames. Either body may be the null
 * handle: that side is then the world itself, and its frame is given in world coordinates.
 */
typedef struct LsJointDef {
    /** Size of this struct in the host, set by ls_joint_def_init. */
    uint32_t struct_size;
    /** LS_JOINT_ constant; default LS_JOINT_FIXED. */
    int32_t kind;
    /** First body, or null for the world; default null. */
    struct LsBody body_a;
    /** Second body, or null for the world; default null. */
    struct LsBody body_b;
    /** Joint frame on body A, in its frame; default its own. */
    struct LsPose frame_a;
    /** Joint frame on body B, in its frame; default its own. */
    struct LsPose frame_b;
    /** Give of the rows that hold points together, and of a distance joint's spring; default rigid. */
    struct LsSoftness linear;
    /** Give of the rows that hold directions together; default rigid. */
    struct LsSoftness angular;
    /** Give of the stops at limits; default rigid. */
    struct LsSoftness limit;
    /** Range of the angle (hinge), translation (prismatic), distance (distance) or twist (spherical); default none. */
    struct LsLimits limits;
    /** Spherical: greatest angle between the two joint axes (rad), 0 to pi; default pi, which is none. */
    float swing_limit;
    /** Distance: length of the spring (m), >= 0; default 0. */
    float spring_length;
    /** Distance: not 0 if there is a spring, whose give is linear; default 0. */
    uint32_t has_spring;
    /** Force at which the joint is reported as overloaded (N), >= 0; default INFINITY, which is never. */
    float break_force;
    /** Torque at which the joint is reported as overloaded (N m), >= 0; default INFINITY, which is never. */
    float break_torque;
    /** Not 0: the two bodies collide with each other; default 0. */
    uint32_t collide_connected;
    /** The host's own word; the library only hands it back. */
    uint64_t user_word;
    /** Drive of a hinge, prismatic or distance joint; default off. */
    struct LsMotor motor;
    /** Drive of a spherical joint; default off. */
    struct LsSphericalMotor spherical_motor;
    /** Generic: translation along x, y, z; default locked at zero. */
    struct LsAxis linear_axes[3];
    /** Generic: rotation about x, y, z; default locked at zero. */
    struct LsAxis angular_axes[3];
} LsJointDef;

/** When bodies fall asleep. */
typedef struct LsSleepSettings {
    /** Not 0: bodies may fall asleep; default 1. */
    uint32_t enabled;
    /** Linear speed below which a body is quiet (m/s); default 0.05. */
    float linear_speed;
    /** Angular speed below which a body is quiet (rad/s); default 0.1. */
    float angular_speed;
    /** How long all bodies of a group must be quiet before it falls asleep (s); default 0.5. */
    float time;
} LsSleepSettings;

/** Everything a world starts with. Fill it with ls_world_def_init first. */
typedef struct LsWorldDef {
    /** Size of this struct in the host, set by ls_world_def_init. */
    uint32_t struct_size;
    /** Gravity (m/s^2); default 0, -9.81, 0. */
    float gravity[3];
    /** Substeps a step, 1 to 256; default 4. More is more accurate and slower. */
    uint32_t substeps;
    /** Sweeps a substep, 1 to 256; default 2. */
    uint32_t iterations;
    /** LS_SOLVER_ constant; default LS_SOLVER_AUTO. */
    int32_t solver;
    /** Threads that step the world, the calling one included, 1 to 64; default 1. Results are the same bits for any number. */
    uint32_t threads;
    /** When bodies fall asleep. */
    struct LsSleepSettings sleep;
    /** Approach speed below which nothing bounces (m/s), >= 0; default 1. */
    float restitution_threshold;
    /** Number of bodies to reserve memory for; a hint; default 0. */
    uint32_t body_capacity;
    /** Number of joints to reserve memory for; a hint; default 0. */
    uint32_t joint_capacity;
    /** Not used; 0. */
    uint32_t reserved;
} LsWorldDef;

/** Names a world. Passed by value; any value is safe. */
typedef struct LsWorld {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsWorld;

/** Report of a step. Later versions append fields. */
typedef struct LsStepReport {
    /** Number of the step; 0 before the first. */
    uint64_t step;
    /** Simulated time (s). */
    double time;
    /** Dynamic bodies awake during the step. */
    uint32_t bodies_awake;
    /** Dynamic bodies asleep. */
    uint32_t bodies_asleep;
    /** Groups of touching or jointed bodies that were solved. */
    uint32_t islands;
    /** Pairs of shapes near each other with a body that can move. */
    uint32_t pairs;
    /** Pairs for which contact points were computed. */
    uint32_t pairs_updated;
    /** Pairs that kept their contact points because they had not moved. */
    uint32_t pairs_reused;
    /** Contacts solved. */
    uint32_t manifolds;
    /** Contact points solved. */
    uint32_t contact_points;
    /** Joints solved. */
    uint32_t joints;
    /** Batches of islands solved independently. */
    uint32_t batches;
    /** Greatest number of contact colours in a batch. */
    uint32_t colors;
    /** Bodies that moved. */
    uint32_t moved;
    /** Worst distance between joint points beyond what the joint allows (m). */
    float joint_gap;
    /** Worst overlap of two shapes before it was recovered (m). */
    float penetration;
    /** Wall time of finding candidate pairs (s). */
    float broad_phase_time;
    /** Wall time of computing contact points (s). */
    float narrow_phase_time;
    /** Wall time of waking and grouping islands (s). */
    float island_time;
    /** Wall time of preparing and solving the constraints (s). */
    float solve_time;
    /** Wall time of writing back, sweeping fast bodies, sleep and events (s). */
    float finish_time;
    /** Wall time of the whole step without callbacks (s). */
    float total_time;
} LsStepReport;

/** Names a joint of one world. Passed by value; any value is safe. */
typedef struct LsJoint {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsJoint;

/** Names a shape on a body of one world. Passed by value; any value is safe. */
typedef struct LsShape {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsShape;

/** Two shapes that touch, or touched, and their bodies. The layout of this struct never changes. */
typedef struct LsContactPair {
    /** First shape; its handle may be stale in an array of contacts that ended. */
    struct LsShape shape_a;
    /** Second shape. */
    struct LsShape shape_b;
    /** Body of the first shape. */
    struct LsBody body_a;
    /** Body of the second shape. */
    struct LsBody body_b;
} LsContactPair;

/** A point of a contact. The layout of this struct never changes. */
typedef struct LsContactPoint {
    /** Halfway between the two surfaces (m). */
    double position[3];
    /** Distance of the surfaces along the normal (m), negative if they overlap. */
    float separation;
    /** Force along the normal in the last substep (N), >= 0. */
    float normal_force;
} LsContactPoint;

/** One contact between two shapes, as the last step left it. The layout of this struct never changes. */
typedef struct LsContact {
    /** The shapes and their bodies. */
    struct LsContactPair pair;
    /** Unit normal, from A to B. */
    float normal[3];
    /** Friction on B, mean over the last substep (N). */
    float friction_force[3];
    /** Number of points, 1 to 4. */
    uint32_t point_count;
    /** Not used; 0. */
    uint32_t reserved;
    /** The points; those beyond point_count are zero. */
    struct LsContactPoint points[4];
} LsContact;

/** A joint whose load passed its break_force or break_torque in a step. The layout of this struct never changes. */
typedef struct LsJointOverload {
    /** The joint. */
    struct LsJoint joint;
    /** The word its host gave it. */
    uint64_t user_word;
    /** Force that it carried, mean over the step (N). */
    float force;
    /** Torque that it carried, mean over the step (N m). */
    float torque;
} LsJointOverload;

/**
 * Receives the joints that a step overloaded, one call each, in the order of ls_world_overloaded_joints_get.
 *
 * Called after the solve on the thread that steps, under its own floating-point settings. It must return normally (no
 * exception, no longjmp). Inside it, reads of the world work, on other threads too; edits return LS_ERROR_WORLD_LOCKED.
 * @param world     the world that steps
 * @param overload  the joint and its load, valid during the call
 * @param user      as given to ls_world_overload_callback_set
 */
typedef void (*LsOverloadCallback)(struct LsWorld world, const struct LsJointOverload *overload, void *user);

/** A body that moved in a step, or fell asleep at its end. The layout of this struct never changes. */
typedef struct LsMoved {
    /** The body. */
    struct LsBody body;
    /** The word its host gave it. */
    uint64_t user_word;
    /** Its frame in the world. */
    struct LsPose pose;
    /** Velocity of its centre of mass (m/s). */
    float linear_velocity[3];
    /** Angular velocity, world axes (rad/s). */
    float angular_velocity[3];
    /** 1 if it fell asleep in this step, else 0. */
    uint32_t fell_asleep;
    /** Not used; 0. */
    uint32_t reserved;
} LsMoved;

/** What a joint does at the end of the last step. Later versions append fields. */
typedef struct LsJointState {
    /** Coordinate of the free axis: angle (rad), translation or distance (m); 0 for other kinds. */
    float position;
    /** Its rate (rad/s or m/s). */
    float velocity;
    /** Force that the joint exerts on body B at its point, world axes, mean over the step (N). */
    float force[3];
    /** Torque that the joint exerts on body B about its point, world axes, mean over the step (N m). */
    float torque[3];
    /** Distance between the two joint points beyond what the joint allows (m). */
    float gap;
} LsJointState;

/** The call did what it says. */
#define LS_OK 0

/** A pointer that must not be NULL is NULL (also: NULL with a count greater than zero). */
#define LS_ERROR_NULL_ARGUMENT 1

/** A handle is zero. */
#define LS_ERROR_NULL_HANDLE 2

/** A handle was never given out, or names an object of another kind. */
#define LS_ERROR_INVALID_HANDLE 3

/** What a handle named has been destroyed. */
#define LS_ERROR_STALE_HANDLE 4

/** A destroy call on an object that was destroyed before. */
#define LS_ERROR_ALREADY_DESTROYED 5

/** A handle belongs to another world, alive or dead. */
#define LS_ERROR_FOREIGN_HANDLE 6

/** A number is NaN or infinite where a finite one is needed. */
#define LS_ERROR_NOT_FINITE 7

/** A number or count is outside the range that the argument allows. */
#define LS_ERROR_OUT_OF_RANGE 8

/** A rotation or direction is more than 1 % away from unit length. */
#define LS_ERROR_NOT_UNIT 9

/** A shape without volume or extent: collinear points, zero extents. */
#define LS_ERROR_DEGENERATE 10

/** An index points past the end of what it indexes. */
#define LS_ERROR_INDEX_OUT_OF_RANGE 11

/** The call does not apply to what it was given, for example a force on a static body. */
#define LS_ERROR_NOT_APPLICABLE 12

/** This build of the library has nothing of that kind. */
#define LS_ERROR_UNSUPPORTED 13

/** A fixed capacity is used up: 1023 worlds alive, or 2^28 objects of a kind in a world. */
#define LS_ERROR_CAPACITY_EXCEEDED 14

/** An enumeration or bit set has a value that this version does not know. */
#define LS_ERROR_INVALID_ENUM 15

/** A struct_size (or size argument) is zero, smaller than the first version of the struct, or greater than 65536. */
#define LS_ERROR_STRUCT_SIZE 16

/** A buffer has room for fewer elements than there are; the number needed has been written to the count. */
#define LS_ERROR_BUFFER_TOO_SMALL 17

/** Another thread is using the world in a way that excludes this call; nothing was waited for. */
#define LS_ERROR_WORLD_BUSY 18

/** The call edits a world from inside a callback. */
#define LS_ERROR_WORLD_LOCKED 19

/** An earlier call on this world ended with LS_ERROR_PANIC; the world can only be destroyed. */
#define LS_ERROR_WORLD_POISONED 20

/** The library failed inside this call, which is a bug in it; the world that was in use is poisoned. */
#define LS_ERROR_PANIC 21

/** A failure that has no code of its own. */
#define LS_ERROR_OTHER 22

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/* The library ----------------------------------------------------------------------------------------------------- */

/**
 * Name of a result code, such as "LS_ERROR_STALE_HANDLE"; for logs and assertions.
 *
 * @param result  any value
 * @return a string that lives as long as the library, never NULL; "unknown result" for a value without a name
 * Threads: any thread at any time. Callbacks: allowed.
 */
const char *ls_result_name_get(LsResult result);

/**
 * Version of the library that the host runs with.
 *
 * @param out  filled on LS_OK
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_version_get(LsVersion *out);

/**
 * Message of the last call that failed on this thread: the function, the argument at fault and what is wrong with it. UTF-8,
 * at most 511 bytes, for people: the wording may change, the codes do not.
 *
 * @return a string owned by the library, never NULL, empty if no call failed on this thread; valid until the next failing
 *         call on this thread or the end of the thread. Calls that succeed leave it as it is.
 * Threads: any thread at any time; each thread has its own. Callbacks: allowed.
 */
const char *ls_last_error_message_get(void);

/**
 * Sets the function that receives log messages of all worlds; at the start there is none.
 *
 * @param callback  called on any thread that calls the library; NULL for none
 * @param level     LS_LOG_OFF, LS_LOG_ERROR or LS_LOG_WARNING: the least important level to be handed over
 * @param user      handed back to the callback; a call that is under way on another thread may still use the old one
 * @return LS_OK, LS_ERROR_INVALID_ENUM
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_log_callback_set(LsLogCallback callback, int32_t level, void *user);

/* Definitions ----------------------------------------------------------------------------------------------------- */

/**
 * Fills a shape definition with defaults: a ball of radius 0.5 m, friction 0.5, density 1000 kg/m^3.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_shape_def_init(LsShapeDef *def, size_t size);

/**
 * Fills a body definition with defaults: dynamic, at the origin, at rest, mass from shapes, no shapes.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_body_def_init(LsBodyDef *def, size_t size);

/**
 * Fills a joint definition with defaults: fixed, rigid, unbreakable, both bodies null.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_joint_def_init(LsJointDef *def, size_t size);

/**
 * Fills a world definition with defaults.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_world_def_init(LsWorldDef *def, size_t size);

/* Worlds ---------------------------------------------------------------------------------------------------------- */

/**
 * Creates an empty world.
 *
 * @param def  filled by ls_world_def_init and changed as wanted; read during the call
 * @param out  the world, on LS_OK; the host destroys it with ls_world_destroy
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_UNSUPPORTED, LS_ERROR_CAPACITY_EXCEEDED
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_world_create(const LsWorldDef *def, LsWorld *out);

/**
 * Destroys a world with all it holds; its handles and arrays end here. A poisoned world can be destroyed like any other.
 *
 * @param world  the world; any value is safe
 * @return LS_OK, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_ALREADY_DESTROYED, LS_ERROR_WORLD_BUSY,
 *         LS_ERROR_WORLD_LOCKED
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_destroy(LsWorld world);

/**
 * Report of the last step.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_report_get(LsWorld world, LsStepReport *out, size_t size);

/**
 * The definition that the world has now: as it was created, with the present gravity.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_def_get(LsWorld world, LsWorldDef *out, size_t size);

/**
 * Gravity (m/s^2).
 *
 * @param world  the world; any value is safe
 * @param out    three floats, filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_gravity_get(LsWorld world, float out[3]);

/**
 * Sets gravity (m/s^2) and wakes all bodies.
 *
 * @param world    the world; any value is safe
 * @param gravity  three finite floats
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_gravity_set(LsWorld world, const float gravity[3]);

/**
 * Simulated time (s): the sum of all steps.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_time_get(LsWorld world, double *out);

/**
 * Number of steps taken.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_step_count_get(LsWorld world, uint64_t *out);

/**
 * Number of bodies.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_body_count_get(LsWorld world, size_t *out);

/**
 * Number of awake dynamic bodies.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_awake_body_count_get(LsWorld world, size_t *out);

/**
 * Number of shapes.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_shape_count_get(LsWorld world, size_t *out);

/**
 * Number of joints.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_joint_count_get(LsWorld world, size_t *out);

/**
 * Hash of the poses and velocities of all bodies, bit for bit: equal for equal states, whatever the number of threads.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_state_hash_get(LsWorld world, uint64_t *out);

/**
 * All bodies.
 *
 * @param world     the world; any value is safe
 * @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of handles that fit
 * @param count     number of bodies, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_bodies_get(LsWorld world, LsBody *out, size_t capacity, size_t *count);

/**
 * All joints.
 *
 * @param world     the world; any value is safe
 * @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of handles that fit
 * @param count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_joints_get(LsWorld world, LsJoint *out, size_t capacity, size_t *count);

/**
 * All contacts of awake bodies.
 *
 * @param world     the world; any value is safe
 * @param out       room for capacity contacts, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of contacts that fit
 * @param count     number of contacts, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_contacts_get(LsWorld world, LsContact *out, size_t capacity, size_t *count);

/**
 * Poses of many bodies in one call.
 *
 * @param world   the world; any value is safe
 * @param bodies  count handles
 * @param count   number of handles; 0 is allowed
 * @param out     room for count poses, filled on LS_OK in the order of the handles; one bad handle, and none is written
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_poses_get(LsWorld world, const LsBody *bodies, size_t count, LsPose *out);

/**
 * Steps a world by dt, then calls its callbacks.
 *
 * A body that the step would have given a state that is NaN or infinite is quarantined (ls_world_quarantined_bodies_get); the rest goes on.
 * @param world  the world; any value is safe
 * @param dt     step (s), 1e-6 to 1; the same each time gives the best results, 1/60 is usual
 * @return LS_OK, a world error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_PANIC
 * Threads: edit; reads become possible while the callbacks run. Callbacks: LS_ERROR_WORLD_LOCKED; another world may be stepped.
 */
LsResult ls_world_step(LsWorld world, float dt);

/**
 * Sets the function that receives overloaded joints; at the start there is none.
 *
 * @param world     the world; any value is safe
 * @param callback  called by ls_world_step; NULL for none
 * @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
 * @return LS_OK, a world error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_overload_callback_set(LsWorld world, LsOverloadCallback callback, void *user);

/**
 * Bodies that moved in the last step, with their poses and velocities, those that fell asleep at its end included.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_moved_bodies_get(LsWorld world, const LsMoved **out, size_t *count);

/**
 * Pairs of shapes that began to touch in the last step.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_contacts_begun_get(LsWorld world, const LsContactPair **out, size_t *count);

/**
 * Pairs of shapes that ceased to touch in the last step.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_contacts_ended_get(LsWorld world, const LsContactPair **out, size_t *count);

/**
 * Joints that carried more than their break_force or break_torque in the last step. They are reported, not removed.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_overloaded_joints_get(LsWorld world, const LsJointOverload **out, size_t *count);

/**
 * Bodies that the last step would have given a state that is NaN or infinite. They stay where they were, without contacts, until
 * the host gives them a pose or velocity.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_quarantined_bodies_get(LsWorld world, const LsBody **out, size_t *count);

/* Bodies ---------------------------------------------------------------------------------------------------------- */

/**
 * Creates a body.
 *
 * @param world  the world; any value is safe
 * @param def    filled by ls_body_def_init and changed as wanted; read during the call
 * @param out    the body, on LS_OK; the world owns it
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_INDEX_OUT_OF_RANGE,
 *         LS_ERROR_NOT_APPLICABLE, LS_ERROR_CAPACITY_EXCEEDED
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_create(LsWorld world, const LsBodyDef *def, LsBody *out);

/**
 * Destroys a body with its shapes and joints, and wakes what touched it.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @return LS_OK, a world error, a handle error, LS_ERROR_ALREADY_DESTROYED
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_destroy(LsWorld world, LsBody body);

/**
 * LS_BODY_ constant of a body.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_kind_get(LsWorld world, LsBody body, int32_t *out);

/**
 * The host's own word of a body.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_user_word_get(LsWorld world, LsBody body, uint64_t *out);

/**
 * Sets the host's own word of a body.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param word   any value
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_user_word_set(LsWorld world, LsBody body, uint64_t word);

/**
 * All shapes of a body.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of handles that fit
 * @param count     number of shapes, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_shapes_get(LsWorld world, LsBody body, LsShape *out, size_t capacity, size_t *count);

/**
 * All joints of a body.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of handles that fit
 * @param count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_joints_get(LsWorld world, LsBody body, LsJoint *out, size_t capacity, size_t *count);

/**
 * Frame of a body in the world.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_pose_get(LsWorld world, LsBody body, LsPose *out);

/**
 * Puts a body somewhere else at once and wakes it and what it touched; velocities stay. To move a kinematic body so that it
 * pushes, use ls_body_move_to.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param pose   its new frame
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_pose_set(LsWorld world, LsBody body, const LsPose *pose);

/**
 * Says where a kinematic body shall be at the end of the next step; it moves there with the velocity that takes, and then
 * stands still unless it is told again.
 *
 * @param world   the world; any value is safe
 * @param body    a body of that world; any value is safe
 * @param target  its frame at the end of the next step
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_move_to(LsWorld world, LsBody body, const LsPose *target);

/**
 * Centre of mass of a body in the world (m).
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    three doubles, filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_center_of_mass_get(LsWorld world, LsBody body, double out[3]);

/**
 * Velocity of a body's centre of mass (m/s).
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    three floats, filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_linear_velocity_get(LsWorld world, LsBody body, float out[3]);

/**
 * Sets the velocity of a body's centre of mass (m/s).
 *
 * @param world            the world; any value is safe
 * @param body             a body of that world; any value is safe
 * @param linear_velocity  three floats (m/s), together at most 1e4
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_linear_velocity_set(LsWorld world, LsBody body, const float linear_velocity[3]);

/**
 * Angular velocity of a body, world axes (rad/s).
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    three floats, filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_angular_velocity_get(LsWorld world, LsBody body, float out[3]);

/**
 * Sets the angular velocity of a body, world axes (rad/s).
 *
 * @param world             the world; any value is safe
 * @param body              a body of that world; any value is safe
 * @param angular_velocity  three floats (rad/s), together at most 1e4
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_angular_velocity_set(LsWorld world, LsBody body, const float angular_velocity[3]);

/**
 * Adds a force at a dynamic body's centre of mass, for the next step.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param force  three floats (N)
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_force_add(LsWorld world, LsBody body, const float force[3]);

/**
 * Adds a force at a point of a dynamic body, for the next step.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param force  three floats (N)
 * @param point  three doubles: where it acts, in the world (m)
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_force_add_at(LsWorld world, LsBody body, const float *force, const double *point);

/**
 * Adds a torque to a dynamic body, world axes, for the next step.
 *
 * @param world   the world; any value is safe
 * @param body    a body of that world; any value is safe
 * @param torque  three floats (N m)
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_torque_add(LsWorld world, LsBody body, const float torque[3]);

/**
 * Adds an impulse at a dynamic body's centre of mass, at once.
 *
 * @param world    the world; any value is safe
 * @param body     a body of that world; any value is safe
 * @param impulse  three floats (N s)
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE (beyond 1e4 m/s or rad/s)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_impulse_add(LsWorld world, LsBody body, const float impulse[3]);

/**
 * Adds an impulse at a point of a dynamic body, at once.
 *
 * @param world    the world; any value is safe
 * @param body     a body of that world; any value is safe
 * @param impulse  three floats (N s)
 * @param point    three doubles: where it acts, in the world (m)
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_impulse_add_at(LsWorld world, LsBody body, const float *impulse, const double *point);

/**
 * Adds an angular impulse to a dynamic body, world axes, at once.
 *
 * @param world    the world; any value is safe
 * @param body     a body of that world; any value is safe
 * @param impulse  three floats (N m s)
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE (beyond 1e4 m/s or rad/s)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_angular_impulse_add(LsWorld world, LsBody body, const float impulse[3]);

/**
 * Mass properties of a dynamic body.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (a body without mass),
 *         LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_mass_get(LsWorld world, LsBody body, LsMassProperties *out);

/**
 * Sets where a dynamic body's mass comes from; its frame stays where it is.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param mass   read during the call
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE, LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_mass_set(LsWorld world, LsBody body, const LsMass *mass);

/**
 * Sets the rates at which velocities decay.
 *
 * @param world    the world; any value is safe
 * @param body     a body of that world; any value is safe
 * @param linear   rate for the linear velocity (1/s), >= 0
 * @param angular  rate for the angular velocity (1/s), >= 0
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_damping_set(LsWorld world, LsBody body, float linear, float angular);

/**
 * Sets the factor on the world's gravity.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param scale  any finite number
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_gravity_scale_set(LsWorld world, LsBody body, float scale);

/**
 * Sets which degrees of freedom are taken away.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param axes   bit set of LS_LOCK_ constants
 * @return LS_OK, a world error, a handle error, LS_ERROR_INVALID_ENUM
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_locked_axes_set(LsWorld world, LsBody body, uint32_t axes);

/**
 * Sets whether a body is swept through the step, so that it cannot tunnel through anything thin.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param fast   not 0: it is
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_fast_set(LsWorld world, LsBody body, uint32_t fast);

/**
 * Sets whether a body may fall asleep; one that may not is woken.
 *
 * @param world      the world; any value is safe
 * @param body       a body of that world; any value is safe
 * @param can_sleep  not 0: it may
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_can_sleep_set(LsWorld world, LsBody body, uint32_t can_sleep);

/**
 * Whether a body is awake; static and kinematic bodies always are.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    1 if it is, else 0; filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_awake_get(LsWorld world, LsBody body, uint32_t *out);

/**
 * Wakes a body and everything that fell asleep with it.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_wake(LsWorld world, LsBody body);

/**
 * Puts a dynamic body to sleep with everything it touched or was jointed to in the last step.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_sleep(LsWorld world, LsBody body);

/**
 * Net force of all contacts on a body in the last substep (N).
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    three floats, filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_contact_force_get(LsWorld world, LsBody body, float out[3]);

/**
 * All contacts of a body.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity contacts, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of contacts that fit
 * @param count     number of contacts, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_contacts_get(LsWorld world, LsBody body, LsContact *out, size_t capacity, size_t *count);

/* Shapes ---------------------------------------------------------------------------------------------------------- */

/**
 * Attaches a new shape to a body; a body whose mass comes from its shapes is weighed again.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param def    filled by ls_shape_def_init and changed as wanted; read during the call
 * @param out    the shape, on LS_OK; the body owns it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
 *         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE,
 *         LS_ERROR_INDEX_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_CAPACITY_EXCEEDED
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_shape_attach(LsWorld world, LsBody body, const LsShapeDef *def, LsShape *out);

/**
 * Takes a shape off its body; a body whose mass comes from its shapes is weighed again.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @return LS_OK, a world error, a handle error, LS_ERROR_ALREADY_DESTROYED, LS_ERROR_OUT_OF_RANGE (a dynamic
 *         body would be left without mass)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_shape_destroy(LsWorld world, LsShape shape);

/**
 * Body that a shape is on.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_body_get(LsWorld world, LsShape shape, LsBody *out);

/**
 * The host's own word of a shape.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_user_word_get(LsWorld world, LsShape shape, uint64_t *out);

/**
 * Sets the surface of a shape.
 *
 * @param world     the world; any value is safe
 * @param shape     a shape of that world; any value is safe
 * @param material  read during the call
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_ENUM,
 *         LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_shape_material_set(LsWorld world, LsShape shape, const LsMaterial *material);

/**
 * Sets which other shapes a shape collides with.
 *
 * @param world   the world; any value is safe
 * @param shape   a shape of that world; any value is safe
 * @param filter  read during the call
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_shape_filter_set(LsWorld world, LsShape shape, const LsCollisionFilter *filter);

/* Joints ---------------------------------------------------------------------------------------------------------- */

/**
 * Creates a joint between two bodies, or a body and the world; at least one must be dynamic.
 *
 * @param world  the world; any value is safe
 * @param def    filled by ls_joint_def_init and changed as wanted; read during the call
 * @param out    the joint, on LS_OK; the world owns it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
 *         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_NOT_APPLICABLE,
 *         LS_ERROR_CAPACITY_EXCEEDED
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_create(LsWorld world, const LsJointDef *def, LsJoint *out);

/**
 * Destroys a joint.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @return LS_OK, a world error, a handle error, LS_ERROR_ALREADY_DESTROYED
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_destroy(LsWorld world, LsJoint joint);

/**
 * The definition that a joint has now. It may be given to ls_joint_create.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param out    filled on LS_OK; fields that the kind does not name have their defaults
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_joint_def_get(LsWorld world, LsJoint joint, LsJointDef *out, size_t size);

/**
 * What a joint does at the end of the last step.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param out    filled on LS_OK
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_joint_state_get(LsWorld world, LsJoint joint, LsJointState *out, size_t size);

/**
 * Sets what a joint allows: new limits or motors of the same kind.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param def    of it, kind and the fields that the kind names are read; kind must be that of the joint
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
 *         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_NOT_APPLICABLE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_kind_set(LsWorld world, LsJoint joint, const LsJointDef *def);

/**
 * Sets the give of a joint.
 *
 * @param world    the world; any value is safe
 * @param joint    a joint of that world; any value is safe
 * @param linear   give of the rows that hold points together, and of a distance joint's spring
 * @param angular  give of the rows that hold directions together
 * @param limit    give of the stops at limits
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_softness_set(LsWorld world,
                               LsJoint joint,
                               const LsSoftness *linear,
                               const LsSoftness *angular,
                               const LsSoftness *limit);

/**
 * Sets the load at which a joint is reported as overloaded.
 *
 * @param world         the world; any value is safe
 * @param joint         a joint of that world; any value is safe
 * @param break_force   (N), >= 0, INFINITY for never
 * @param break_torque  (N m), >= 0, INFINITY for never
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_break_set(LsWorld world, LsJoint joint, float break_force, float break_torque);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LONGSPAN_H */
