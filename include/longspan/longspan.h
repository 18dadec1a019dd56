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

/** Limit of a joint: pulled apart along its axis; a distance joint, along the line between its points. */
#define LS_STRENGTH_TENSION 0

/** Limit of a joint: pressed together along its axis; a distance joint, along the line between its points. */
#define LS_STRENGTH_COMPRESSION 1

/** Limit of a joint: pushed across its axis; never a distance joint, whose force is along its line. */
#define LS_STRENGTH_SHEAR 2

/** Limit of a joint: bent across its axis. */
#define LS_STRENGTH_BENDING 3

/** Limit of a joint: twisted about its axis. */
#define LS_STRENGTH_TORSION 4

/** Cause of a break: the mean load passed a limit. */
#define LS_BREAK_LOAD 0

/** Cause of a break: the joint was worn out. */
#define LS_BREAK_DAMAGE 1

/** Cause of a break: ls_world_fractures_apply named the joint, and it had not passed a limit. */
#define LS_BREAK_APPLIED 2

/** Motor mode: nothing drives the coordinate. */
#define LS_MOTOR_OFF 0

/** Motor mode: holds a speed with at most the greatest force or torque. */
#define LS_MOTOR_VELOCITY 1

/** Motor mode: pulls towards a value as a spring and damper, with at most the greatest force or torque. */
#define LS_MOTOR_POSITION 2

/** Which way a motor may push its coordinate: both ways. */
#define LS_FORCE_BOTH 0

/** Which way a motor may push its coordinate: towards lesser values alone, as a winch or a muscle does. */
#define LS_FORCE_PULL 1

/** Which way a motor may push its coordinate: towards greater values alone, as a jack does. */
#define LS_FORCE_PUSH 2

/** Joint kind: nothing moves. */
#define LS_JOINT_FIXED 0

/** Joint kind: rotation about the joint axis, the angle counts turns; limits, motor, motor_drive, friction. */
#define LS_JOINT_HINGE 1

/** Joint kind: rotation about a point; swing_limit, limits (of the twist, which counts turns), spherical_motor, friction. */
#define LS_JOINT_SPHERICAL 2

/** Joint kind: the distance between two points; limits, has_spring, spring_length, motor, motor_drive. */
#define LS_JOINT_DISTANCE 3

/** Joint kind: translation along the joint axis; limits, motor, motor_drive, friction. */
#define LS_JOINT_PRISMATIC 4

/**
 * Joint kind: six axes of A's frame, each free, locked or limited; linear_axes, angular_axes, axis_drives, axis_friction.
 * Rotations are the angles x, y, z of R_x R_y R_z, which takes A's frame to B's, and count turns. With one free it is a hinge,
 * whichever it is; with x and y or y and z free a universal joint; with three free a spherical joint. Where neither x nor z is
 * locked, these two are one axis at y = 90 degrees: what is asked of them fades there.
 */
#define LS_JOINT_GENERIC 5

/**
 * Plan of an island: joints meet contacts, or close a loop and bear more than a substep resolves, or bodies without joints lean on one another
 * in a row, as stones of an arch, or at rest with few contacts, as cards of a house, or stand on each other on what moves or bear their
 * load aside: all of it is one problem.
 */
#define LS_PLAN_COUPLED 0

/** Plan of an island: no joint is in it: contacts are swept. */
#define LS_PLAN_LOOSE 1

/**
 * Plan of an island: nothing that joints hold touches anything but a few free bodies on points of which there are many: articulations take the
 * step by themselves, with what they carry.
 */
#define LS_PLAN_APART 2

/** Plan of an island: the host asks for sweeps. */
#define LS_PLAN_SWEPT 3

/** Plan of an island: joints have stops on angles, as limbs do, no motor holds a place, and they form a tree that nothing fixed holds: sweeps and direct solves carry its loads for less. */
#define LS_PLAN_JOINTED 4

/** Plan of an island: joints do more than hold points together, no motor holds a place, and masses are alike, in a tree that nothing fixed holds or a loop that does not stand: sweeps and direct solves carry loads between such bodies as well, for less. */
#define LS_PLAN_ALIKE 5

/** Plan of an island: articulations touch one another that nothing fixed holds, or with more contacts than joints: a heap. */
#define LS_PLAN_HEAPED 7

/** Plan of an island: a factor of it takes more work than `halving_budget` allows. */
#define LS_PLAN_LARGE 8

/** Solver: the library chooses per group of bodies. */
#define LS_SOLVER_AUTO 0

/** Solver: sweeps over the constraints, with long-range constraints. */
#define LS_SOLVER_GAUSS_SEIDEL 1

/** Solver: direct solve of articulations; sweeps for what its matrix does not fit. */
#define LS_SOLVER_DIRECT 2

/** Query kinds: shapes of static bodies count. */
#define LS_QUERY_STATIC 1

/** Query kinds: shapes of kinematic bodies count. */
#define LS_QUERY_KINEMATIC 2

/** Query kinds: shapes of dynamic bodies count. */
#define LS_QUERY_DYNAMIC 4

/** Part or triangle of a shape that has none. */
#define LS_NO_INDEX UINT32_MAX

/**
 * Layer: outlines of shapes: static grey, kinematic blue, awake orange, held where they are yellow, asleep dim, sensors green,
 * quarantined red.
 */
#define LS_DRAW_SHAPES 1

/** Layer: the same as triangles. */
#define LS_DRAW_SURFACES 2

/** Layer: contact points with their normal from A to B: white where they press, grey where they do not. */
#define LS_DRAW_CONTACTS 4

/** Layer: forces of contacts on B, along the normal red and of friction orange. */
#define LS_DRAW_CONTACT_FORCES 8

/** Layer: joints: lines from both centres of mass to the joint points, and both joint frames. */
#define LS_DRAW_JOINTS 16

/** Layer: limits of joints, and where the joint is between them. */
#define LS_DRAW_JOINT_LIMITS 32

/** Layer: force of each joint as a line on B and as a text (N), coloured by its share of the break force. */
#define LS_DRAW_JOINT_LOADS 64

/** Layer: a box around each island awake, in a colour of its own, and around each asleep, dim; of those with joints how they are solved. */
#define LS_DRAW_ISLANDS 128

/** Layer: long-range bounds: taut ones red with their tension (N), slack ones green with what is left (m). */
#define LS_DRAW_BOUNDS 256

/**
 * Layer: supporting contacts, the hull they span and the centre of mass above it, coloured by verdict; while the support
 * analysis is on.
 */
#define LS_DRAW_SUPPORT 512

/** Layer: centres of mass with principal axes. */
#define LS_DRAW_MASS 1024

/** Layer: velocities of centres of mass. */
#define LS_DRAW_VELOCITIES 2048

/** Layer: boxes that the broad phase keeps. */
#define LS_DRAW_BOXES 4096

/**
 * Layer: planes of hinge chains: a square through them with its normal, and how far each body's centre of mass is off it, which
 * the chain keeps.
 */
#define LS_DRAW_PLANES 8192

/** Layer: unions: a line from the centre of mass of each to every body of it, and their number. */
#define LS_DRAW_UNIONS 16384

/**
 * Recording: the hash of the world's state follows every call, not steps only. Finds the very call that first differs; costs as
 * much as reading all bodies, for each call.
 */
#define LS_RECORD_HASH_EVERY_CALL 1

/** The body stands: its centre of mass lies over the hull of the supporting contacts below it. */
#define LS_SUPPORT_SUPPORTED 0

/** Joints hold the body to the ground, or to a body that is supported. */
#define LS_SUPPORT_HELD_BY_JOINTS 1

/** The body is static, or kinematic and at rest: it needs no support. */
#define LS_SUPPORT_GROUND 2

/** Nothing presses against the body from below. */
#define LS_SUPPORT_NO_CONTACT 3

/** Every contact below the body slides. */
#define LS_SUPPORT_SLIDING 4

/** What the body stands on carries no load there: it is unsupported itself, moves, or ends before there. */
#define LS_SUPPORT_ON_UNSUPPORTED 5

/** The body's centre of mass lies outside the hull of its supporting contacts, or on its edge. */
#define LS_SUPPORT_OUTSIDE_HULL 6

/** Joints tie the body to others, none of which is supported. */
#define LS_SUPPORT_HANGING_LOOSE 7

/** The body is kinematic and on the move. */
#define LS_SUPPORT_MOVING 8

/** There is no gravity. */
#define LS_SUPPORT_NO_GRAVITY 9

/** The pushes of contacts that hold balance the body's weight, though they are not all below it: it is held up. */
#define LS_SUPPORT_BRACED 10

/** Bound: from a static or kinematic attachment to what hangs on it. */
#define LS_BOUND_ATTACHMENT 0

/** Bound: between two bodies that are free. */
#define LS_BOUND_HIERARCHY 1

/** Bound: asked for by the host between two joints. */
#define LS_BOUND_SOFT 2

/** Reader status: there is a newer frame. */
#define LS_STREAM_FRAME 0

/** Reader status: nothing new. */
#define LS_STREAM_NOTHING 1

/** Reader status: no publisher is there. The reader goes on looking for one. */
#define LS_STREAM_GONE 2

/** Reader status: the recording is over. */
#define LS_STREAM_END 3

/** Recording end: it was finished. */
#define LS_STREAM_RECORDING_FINISHED 0

/** Recording end: it was cut short. */
#define LS_STREAM_RECORDING_CUT 1

/** Recording end: some of it is damaged and left out. */
#define LS_STREAM_RECORDING_DAMAGED 2

/** Event: the joint `a` carried more than its limit; values: force (N), torque (N m). */
#define LS_STREAM_EVENT_OVERLOAD 1

/** Event: the joint `a` broke; values: mean force (N) and torque (N m) over its window. LsStreamBreak has the rest. */
#define LS_STREAM_EVENT_BROKEN 2

/**
 * Event: the union of the body `a` has fallen apart, or lost its anchor; one for each piece, and `b` is a body of it.
 * LsStreamPiece has the rest.
 */
#define LS_STREAM_EVENT_SPLIT 3

/** Event: the body `a` is supported from now on. */
#define LS_STREAM_EVENT_SUPPORT_GAINED 4

/** Event: the body `a` is no longer supported. */
#define LS_STREAM_EVENT_SUPPORT_LOST 5

/** Event: the body `a` had a state that is NaN or infinite, and is taken out of the simulation. */
#define LS_STREAM_EVENT_QUARANTINED 6

/** Event: a contact between the bodies `a` and `b` began. */
#define LS_STREAM_EVENT_CONTACT_BEGAN 7

/** Event: a contact between the bodies `a` and `b` ended. */
#define LS_STREAM_EVENT_CONTACT_ENDED 8

/** Section of LsStreamMotion. */
#define LS_STREAM_SECTION_MOTION 1

/** Section of LsStreamContact. */
#define LS_STREAM_SECTION_CONTACT 2

/** Section of LsStreamJointLoad. */
#define LS_STREAM_SECTION_JOINT_LOAD 3

/** Section of LsStreamBound. */
#define LS_STREAM_SECTION_BOUND 4

/** Section of LsStreamPlane. */
#define LS_STREAM_SECTION_PLANE 5

/** Layer of a stream: contacts of awake bodies, in every frame. */
#define LS_STREAM_LAYER_CONTACTS 1

/** Layer of a stream: what each joint carries, in every frame. */
#define LS_STREAM_LAYER_JOINT_LOADS 2

/** Layer of a stream: long-range bounds, in every frame. */
#define LS_STREAM_LAYER_BOUNDS 4

/** Layer of a stream: planes of hinge chains, in every frame. */
#define LS_STREAM_LAYER_PLANES 8

/** Layer of a stream: an event for each contact that begins or ends. */
#define LS_STREAM_LAYER_CONTACT_EVENTS 16

/** All layers that this version knows. */
#define LS_STREAM_LAYER_ALL 31

/** Body flag: it sleeps. */
#define LS_STREAM_BODY_ASLEEP 1

/** Body flag: whether it is supported is known. */
#define LS_STREAM_BODY_SUPPORT_KNOWN 2

/** Body flag: it is supported. */
#define LS_STREAM_BODY_SUPPORTED 4

/** Body flag: it is of a piece of something that fell apart since the stream was opened. */
#define LS_STREAM_BODY_BROKEN 8

/** The first eight bytes of every message: "LSSTREAM". */
#define LS_STREAM_MAGIC 5566806834311025484

/** Number of the library's binary interface, which is part of the names of streams; LS_ABI_VERSION. */
#define LS_STREAM_ABI 0

/** Number of the schema: another one means bytes that a reader of this one cannot read. */
#define LS_STREAM_SCHEMA 1

/** Channel of frames: one message a published step, the latest wins. */
#define LS_STREAM_CHANNEL_HOT 1

/** Channel of records: ordered, none is left out, as long as a reader does not fall behind by more than the history. */
#define LS_STREAM_CHANNEL_COLD 2

/** Message flag: the whole scene begins to be told anew with this message. */
#define LS_STREAM_CYCLE_BEGINS 1

/** Message flag: with this message the whole scene has been told. */
#define LS_STREAM_CYCLE_ENDS 2

/** Message flag: state_hash is that of the world after the step. */
#define LS_STREAM_HAS_STATE_HASH 4

/** Section of LsStreamBody. */
#define LS_STREAM_SECTION_BODY 32

/** Section of LsStreamShape. */
#define LS_STREAM_SECTION_SHAPE 33

/** Section of LsStreamJoint. */
#define LS_STREAM_SECTION_JOINT 34

/** Section of LsStreamGone, for bodies. */
#define LS_STREAM_SECTION_BODY_GONE 35

/** Section of LsStreamGone, for shapes. */
#define LS_STREAM_SECTION_SHAPE_GONE 36

/** Section of LsStreamGone, for joints. */
#define LS_STREAM_SECTION_JOINT_GONE 37

/** Section of one LsStreamGeometry, its vertices (3 floats each) and its triangles (3 uint32_t each). */
#define LS_STREAM_SECTION_GEOMETRY 38

/** Section of LsStreamEvent. */
#define LS_STREAM_SECTION_EVENT 39

/** Section of LsStreamWorld. */
#define LS_STREAM_SECTION_WORLD 40

/** Section of LsStreamBreak. */
#define LS_STREAM_SECTION_BREAK 41

/** Section of LsStreamPiece. */
#define LS_STREAM_SECTION_PIECE 42

/** Joint flag: it can break. */
#define LS_STREAM_JOINT_BREAKABLE 1

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

/**
 * Gives memory; given in an LsAllocator. Called on any thread that uses the library or that it started.
 * @param size       number of bytes, > 0
 * @param alignment  a power of two
 * @param user       as given in the LsAllocator
 * @return memory of that size and alignment, or NULL, which ends the process
 */
typedef void *(*LsAllocateCallback)(size_t size, size_t alignment, void *user);

/**
 * Takes memory back; given in an LsAllocator. Called on any thread.
 * @param memory     as the allocate callback gave it
 * @param size       as asked for then
 * @param alignment  as asked for then
 * @param user       as given in the LsAllocator
 */
typedef void (*LsReleaseCallback)(void *memory, size_t size, size_t alignment, void *user);

/**
 * Who gives the library its memory. The layout of this struct never changes.
 *
 * The callbacks must return normally (no exception, no longjmp) and must not call the library.
 */
typedef struct LsAllocator {
    /** Gives memory; not NULL. */
    LsAllocateCallback allocate;
    /** Takes it back; not NULL. */
    LsReleaseCallback release;
    /** Handed back to the callbacks. */
    void *user;
} LsAllocator;

/** Memory that the library holds. Later versions append fields. */
typedef struct LsMemory {
    /** Bytes held now, by all worlds together. */
    uint64_t bytes;
    /** Most bytes held at any time. */
    uint64_t peak_bytes;
    /** Blocks held now. */
    uint64_t blocks;
    /** Blocks asked for so far: a step that allocates nothing leaves it as it is. */
    uint64_t allocations;
} LsMemory;

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
    /**
     * Not 0: a sensor, which only tells what it overlaps (ls_world_sensor_overlaps_begun_get): it touches nothing, no query finds it, and it
     * has no mass; default 0.
     */
    uint32_t sensor;
    /** Not used; 0. */
    uint32_t reserved;
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
    /** Rate k at which linear velocity decays (1/s), >= 0; default 0. Implicit: v / (1 + k h) in a substep of length h (s). */
    float linear_damping;
    /** Rate k at which angular velocity decays (1/s), >= 0; default 0. Implicit: v / (1 + k h) in a substep of length h (s). */
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

/** How constraint rows give way. Acts as a physical spring and damper whatever the number of substeps and iterations. */
typedef struct LsSoftness {
    /** Inverse stiffness (m/N or rad/(N m)), >= 0; 0 is rigid. */
    float compliance;
    /** Force per relative speed (N s/m or N m s/rad), >= 0; without compliance there is nothing to damp. */
    float damping;
} LsSoftness;

/** Least and greatest value of a coordinate (m or rad); -INFINITY and INFINITY for none. Equal values lock it there. */
typedef struct LsLimits {
    /** Least value (m or rad). */
    float min;
    /** Greatest value (m or rad). */
    float max;
} LsLimits;

/** What drives one coordinate of a joint. */
typedef struct LsMotor {
    /** LS_MOTOR_ constant. */
    int32_t mode;
    /** Speed (m/s or rad/s) or value (m or rad) to reach. */
    float target;
    /** Spring and damper of LS_MOTOR_POSITION; rigid goes to its target as fast as max_force allows, and stops there. */
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
    /** Greatest torque about each axis of A's joint frame (N m), may be INFINITY: about (1, 1, 1) up to 1.73 times as much. */
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
 * What a joint bears before it breaks. Loads are those on body B in axes of the joint's frame on A, whose x axis is taken to
 * point from A to B; INFINITY is never. The layout of this struct never changes.
 *
 * The x axis of a distance joint, be it a rope, a rod or a spring, is the line from its point on A to that on B, whatever its frames: all of
 * its force is tension or compression, and none of it shear.
 *
 * Loads are compared as their mean over the window: an impulse J counts as J / window whatever the length of the step, a steady
 * load as itself. Damage grows by (share - damage_from) / (1 - damage_from) / damage_time a second while the joint bears more
 * than damage_from of a limit, and halves every damage_half_life; at 1 the joint breaks.
 */
typedef struct LsStrength {
    /** Greatest force that pulls B away from A along the axis (N), >= 0; default INFINITY. */
    float tension;
    /** Greatest force that presses B against A along the axis (N), >= 0; default INFINITY. */
    float compression;
    /** Greatest force across the axis (N), >= 0; default INFINITY. */
    float shear;
    /** Greatest torque across the axis (N m), >= 0; default INFINITY. */
    float bending;
    /** Greatest torque about the axis (N m), >= 0; default INFINITY. */
    float torsion;
    /** Time over which loads are averaged (s), above 0, at most 10; default 1/60. A longer step is a window of its own. */
    float window;
    /** Not 0: loads below the limits wear the joint out; default 0. */
    uint32_t wears;
    /** Fraction of a limit from which it wears, 0 to below 1; read if wears; default 0.5. */
    float damage_from;
    /** Time after which a new joint at its limit is worn out (s), > 0; read if wears; default 1. */
    float damage_time;
    /** Time in which damage halves (s), > 0, INFINITY if it stays; read if wears; default INFINITY. */
    float damage_half_life;
} LsStrength;

/** Further settings of a motor, beside those of LsMotor. */
typedef struct LsDrive {
    /**
     * LS_MOTOR_POSITION: speed at which its target moves (m/s or rad/s); default 0. Damping acts on the difference to it, and the target
     * is where target says at the end of the step: set both before each step.
     */
    float target_velocity;
    /**
     * LS_MOTOR_POSITION: greatest speed on the way to the target (m/s or rad/s), >= 0; default INFINITY. A spring drives no
     * faster than this, but does not brake a coordinate that something else drives faster.
     */
    float max_speed;
    /** LS_FORCE_ constant: which way the motor may push; default LS_FORCE_BOTH. */
    int32_t side;
    /** Not used; 0. */
    uint32_t reserved;
} LsDrive;

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
    /**
     * Not 0: the two bodies collide with each other; default 0. Two bodies that joints hold at one point of a third, or of the world, so that
     * they overlap by a tenth of the thinner one however they turn, never collide.
     */
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
    /** What the joint bears before it breaks; default unbreakable. */
    struct LsStrength strength;
    /** Not 0: long-range constraints are derived from it: bounds past it, planes of hinges, unions of fixed joints; default 1. */
    uint32_t long_range;
    /** Not used; 0. */
    uint32_t reserved;
    /**
     * LS_SOLVER_ constant: how the articulation that it belongs to is solved; default LS_SOLVER_AUTO, which is as the world says. One
     * joint that asks for sweeps is enough for these, and else one that asks for the direct solve.
     */
    int32_t solver;
    /** Not used; 0. */
    uint32_t reserved_too;
    /**
     * Dry friction, >= 0: of a hinge about its axis (N m), of a prismatic joint along it (N), of a spherical joint against any rotation
     * (N m, the greatest length of its torque); default 0.
     */
    float friction;
    /** Generic: dry friction along x, y, z (N), then about them (N m), >= 0; default 0. */
    float axis_friction[6];
    /** Coefficient of restitution of its rigid stops, 0 to 1: a limit that is met at v is left at this share of v; default 0. */
    float restitution;
    /** What more the motor of a hinge, prismatic or distance joint is told; default nothing. */
    struct LsDrive motor_drive;
    /** Generic: what more the motors of its axes are told, along x, y and z, then about them; default nothing. */
    struct LsDrive axis_drives[6];
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

/** Whether and how fast joints break. The layout of this struct never changes. */
typedef struct LsFractureSettings {
    /** Not 0: joints break by their own load; default 1. If 0, only what ls_world_fractures_apply names does, as on a client. */
    uint32_t by_load;
    /** Most joints that break in a step, >= 1; the rest do in the steps after, in order of their handles; default 4096. */
    uint32_t most;
} LsFractureSettings;

/** Everything a world starts with. Fill it with ls_world_def_init first. */
typedef struct LsWorldDef {
    /** Size of this struct in the host, set by ls_world_def_init. */
    uint32_t struct_size;
    /** Gravity (m/s^2); default 0, -9.81, 0. */
    float gravity[3];
    /**
     * Substeps a step, 1 to 256; default 4. More is more accurate and slower. Articulations that move by themselves take as many as their
     * errors ask for, and islands in which jointed bodies carry loads smoothly half of them, from four on, where no error target is set.
     */
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
    /** Number of bodies, of one shape each, to reserve memory for; a hint; default 0. */
    uint32_t body_capacity;
    /** Number of joints to reserve memory for; a hint; default 0. */
    uint32_t joint_capacity;
    /** Not used; 0. */
    uint32_t reserved;
    /** Not 0: groups that stand still on supporting contacts are held where they are until anything touches them; default 1. */
    uint32_t hold;
    /** Not 0: every step ends with the support analysis, as after ls_support_enabled_set; default 0. */
    uint32_t support;
    /**
     * Approach speed above which contacts are listed by ls_world_hits_get (m/s), >= 0; default INFINITY, which is never and costs
     * nothing.
     */
    float hit_threshold;
    /** Whether and how fast joints break. */
    struct LsFractureSettings fracture;
    /** Not 0: the support analysis also finds what stands by thrust: arches, leaning cards, wedges; default 0. */
    uint32_t support_by_thrust;
} LsWorldDef;

/** Names a world. Passed by value; any value is safe. */
typedef struct LsWorld {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsWorld;

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

/**
 * Receives pairs of shapes of a step; given in an LsCallbacks.
 *
 * Each callback of an LsCallbacks is called once a step, if there is anything to tell, after the solve on the thread that steps,
 * under its own floating-point settings, in the order in which they stand in the struct. They must return normally (no exception,
 * no longjmp). Inside them reads of the world work, on other threads too; edits return LS_ERROR_WORLD_LOCKED.
 * @param world  the world that steps
 * @param pairs  count pairs: the array of the function of the same name, valid as long as that
 * @param count  number of pairs, > 0
 * @param user   as given in the LsCallbacks
 */
typedef void (*LsPairsCallback)(struct LsWorld world, const struct LsContactPair *pairs, size_t count, void *user);

/** A contact whose shapes met fast. The layout of this struct never changes. */
typedef struct LsHit {
    /** The shapes and their bodies. */
    struct LsContactPair pair;
    /** Where they touch, the middle of the pressed points (m). */
    double point[3];
    /** Unit normal, from A to B. */
    float normal[3];
    /** Greatest speed at which points approached each other at the start of a step (m/s). */
    float approach_speed;
    /** Impulse along the normal over the steps of the hit, one or two, rebound included (N s). */
    float impulse;
    /** Not used; 0. */
    uint32_t reserved;
} LsHit;

/**
 * Receives the hits of a step; given in an LsCallbacks, see LsPairsCallback.
 * @param world  the world that steps
 * @param hits   count hits: the array of ls_world_hits_get
 * @param count  number of hits, > 0
 * @param user   as given in the LsCallbacks
 */
typedef void (*LsHitsCallback)(struct LsWorld world, const struct LsHit *hits, size_t count, void *user);

/** Names a joint of one world. Passed by value; any value is safe. */
typedef struct LsJoint {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsJoint;

/** A joint that has come to one of its stops. The layout of this struct never changes. */
typedef struct LsJointStop {
    /** The joint. */
    struct LsJoint joint;
    /** The word its host gave it. */
    uint64_t user_word;
    /**
     * Which coordinate: 0 for the only one of a hinge, prismatic or distance joint and for the twist of a spherical one, 1 for its
     * swing; 0 to 2 for the translations and 3 to 5 for the rotations of a generic joint.
     */
    uint32_t axis;
    /** 1 if it is the upper stop, else 0. */
    uint32_t upper;
} LsJointStop;

/**
 * Receives the joints that came to a stop in a step; given in an LsCallbacks, see LsPairsCallback.
 * @param world  the world that steps
 * @param stops  count joints: the array of ls_world_joint_stops_get
 * @param count  number of joints, > 0
 * @param user   as given in the LsCallbacks
 */
typedef void (*LsJointStopsCallback)(struct LsWorld world, const struct LsJointStop *stops, size_t count, void *user);

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
    /** 1 if it woke in this step or since the one before it, else 0. */
    uint32_t woke;
} LsMoved;

/**
 * Receives the bodies that moved in a step; given in an LsCallbacks, see LsPairsCallback.
 * @param world  the world that steps
 * @param moved  count bodies: the array of ls_world_moved_bodies_get
 * @param count  number of bodies, > 0
 * @param user   as given in the LsCallbacks
 */
typedef void (*LsMovedCallback)(struct LsWorld world, const struct LsMoved *moved, size_t count, void *user);

/** Who is told what a step did. Fill it with ls_callbacks_init first. */
typedef struct LsCallbacks {
    /** Size of this struct in the host, set by ls_callbacks_init. */
    uint32_t struct_size;
    /** Not used; 0. */
    uint32_t reserved;
    /** Handed back to all callbacks; default NULL. */
    void *user;
    /** Receives contacts that began; NULL, the default, for none. */
    LsPairsCallback contact_began;
    /** Receives contacts that ended; default NULL. */
    LsPairsCallback contact_ended;
    /** Receives hits; default NULL. */
    LsHitsCallback hits;
    /** Receives shapes that began to overlap sensors; default NULL. */
    LsPairsCallback sensor_began;
    /** Receives shapes that ceased to overlap sensors; default NULL. */
    LsPairsCallback sensor_ended;
    /** Receives joints that came to a stop; default NULL. */
    LsJointStopsCallback joint_stops;
    /** Receives bodies that moved; default NULL. */
    LsMovedCallback moved;
} LsCallbacks;

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
    /** Unions awake and free, each solved as one body. */
    uint32_t unions;
    /** Bodies that moved as members of those. */
    uint32_t union_members;
    /** Worst angle by which a joint or a stop of an articulation is off (rad). */
    float joint_angle;
    /** Of the long-range bounds of bodies awake, how many were wrapped around what their chain lies on. */
    uint32_t bounds_wrapped;
    /** Long-range bounds derived in this step; 0 where nothing has changed that they follow from. */
    uint32_t bounds_derived;
    /** Long-range bounds of bodies awake. */
    uint32_t bounds;
    /** Of those, how many were taut or nearly so. */
    uint32_t bounds_active;
    /** Of those, how many were so slack that the step did not look at them again. */
    uint32_t bounds_skipped;
    /** Hinge chains kept in a plane. */
    uint32_t planes;
    /** Wall time of deriving long-range constraints and handing them out (s). */
    float long_range_time;
} LsStepReport;

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

/** How an articulation was solved in a step: bodies that joints connect, solved at once. The layout of this struct never changes. */
typedef struct LsArticulation {
    /** One of its bodies. */
    struct LsBody body;
    /** Bodies that it moves. */
    uint32_t bodies;
    /** Joints. */
    uint32_t joints;
    /**
     * 1 if it touched what moves, or its contacts did not settle in one system with its joints, so that these were swept with the
     * contacts, else 0.
     */
    uint32_t swept;
    /** Substeps of second order. */
    uint32_t second_order;
    /** Smooth substeps of first order. */
    uint32_t first_order;
    /** Substeps in which kinetic energy cannot grow: safe ones, and all of those in which it was swept. */
    uint32_t safe;
    /** Substeps that were undone and taken as two halves. */
    uint32_t halvings;
    /** Numbers in its factor. */
    uint32_t factor_size;
    /** Worst distance between joint points beyond what the joint allows (m). */
    float gap;
    /** Worst angle by which a joint or a stop is off (rad). */
    float angle;
    /** Worst overlap with what it does not move (m). */
    float penetration;
    /** Change of kinetic energy that the work of gravity and applied forces does not explain (N m); 0 where it was swept. */
    float energy_change;
} LsArticulation;

/** How an island was solved in a step: bodies that joints and contacts connect. The layout of this struct never changes. */
typedef struct LsIsland {
    /** One of its bodies. */
    struct LsBody body;
    /** Bodies that it moves. */
    uint32_t bodies;
    /** Joints. */
    uint32_t joints;
    /** How it was to be solved, and why: an LS_PLAN_ constant; later versions may have more. */
    int32_t plan;
    /** 1 if the coupled solve did not reach a result that it could vouch for, so that sweeps and direct solves took the step, else 0. */
    uint32_t given_up;
} LsIsland;

/**
 * How much work articulations may take: bodies that joints connect and that are solved at once. The layout of this struct never
 * changes.
 */
typedef struct LsArticulationSettings {
    /**
     * How far any body of a smooth articulation may be from its exact path after about a second (m), >= 0; the engine chooses its
     * substeps for that, up to `most_substeps`. Default 0: about a thousandth of its extent, as the mean over its mass.
     */
    float error_target;
    /**
     * Most substeps of a smooth articulation over those of the world, up to 64; the least is one a step. Default 0: 4, with an error
     * target 16.
     */
    uint32_t most_substeps;
    /**
     * Multiplications that the factorisations of halved substeps, and of long searches for active sets, may take in a step of an
     * articulation, in millions, 0 to 1e6; default 10. Once they are spent, joints may stay open until a later step, and contacts
     * are swept; energy does not grow. An island of joints and contacts is solved as one problem if a few factorisations of it a
     * substep are within this.
     */
    float halving_budget;
} LsArticulationSettings;

/**
 * Does the parts begin, begin + 1, ... end - 1 of a job; given to an LsParallelForCallback, which calls it on any threads.
 * @param job    as given to the callback
 * @param begin  first part
 * @param end    one past the last part
 */
typedef void (*LsJobFunction)(void *job, size_t begin, size_t end);

/**
 * Has the parts 0, 1, ... count - 1 of a job done, by calls of run for ranges that do not overlap and leave nothing out, on any
 * threads, and returns when all those calls have returned. A host without threads calls run(job, 0, count).
 *
 * Called on the thread that steps, a few times a step, under its own floating-point settings; parts take from 10 microseconds to
 * milliseconds each. It must return normally (no exception, no longjmp). The world that steps cannot be used inside it.
 * @param count  number of parts
 * @param run    does parts; never NULL
 * @param job    to be handed to run
 * @param user   as given to ls_world_parallel_for_set
 */
typedef void (*LsParallelForCallback)(size_t count, LsJobFunction run, void *job, void *user);

/**
 * Told that a zone of a step begins or ends; given to ls_world_profiler_set.
 *
 * Zones nest: "longspan step" around one for each stage. Called on the thread that steps, under its own floating-point settings.
 * It must return normally (no exception, no longjmp). The world that steps cannot be used inside it.
 * @param name  UTF-8, lives as long as the library: the same pointer each time
 * @param user  as given to ls_world_profiler_set
 */
typedef void (*LsZoneCallback)(const char *name, void *user);

/**
 * Has the last word on a shape whose box a query meets.
 *
 * Called during the query under the host's floating-point settings, in any order, in ls_world_rays_cast on any thread of the
 * world. It must return normally (no exception, no longjmp). Inside it, reads of the world work; edits return
 * LS_ERROR_WORLD_BUSY.
 * @param shape  the shape
 * @param user   as given in the filter
 * @return not 0 if the shape counts
 */
typedef uint32_t (*LsQueryCallback)(struct LsShape shape, void *user);

/** Which shapes a query is about. Fill it with ls_query_filter_init first; where a filter is asked for, NULL means everything. */
typedef struct LsQueryFilter {
    /** Size of this struct in the host, set by ls_query_filter_init. */
    uint32_t struct_size;
    /** Bit set of groups the query belongs to, as if it were a shape; default all. */
    uint32_t member_of;
    /** Bit set of groups the query meets; default all. */
    uint32_t collides_with;
    /** Bit set of LS_QUERY_ constants: which kinds of body count; default all. */
    uint32_t kinds;
    /** Bodies that do not count; any handles are allowed. Default none. */
    const struct LsBody *ignored;
    /** Number of bodies that do not count. */
    size_t ignored_count;
    /** Has the last word on each shape; default NULL. */
    LsQueryCallback accept;
    /** Handed back to the callback. */
    void *user;
} LsQueryFilter;

/** What is cast: a solid or a point on a straight path, with or without a turn. Fill it with ls_cast_def_init first. */
typedef struct LsCastDef {
    /** Size of this struct in the host, set by ls_cast_def_init. */
    uint32_t struct_size;
    /**
     * Not 0: leaves out what is overlapped or touched at the start; of a mesh, a height field or a compound those triangles or
     * parts alone. Default 0.
     */
    uint32_t ignore_overlapped;
    /**
     * A solid, so no half-space, mesh or height field; of it, only its geometry is read. Default NULL: a point, whose way is a
     * ray.
     */
    const struct LsShapeDef *shape;
    /** Where it begins; default the origin. */
    struct LsPose pose;
    /** How far its origin goes (m), together at most 1e7; default zero. */
    double path[3];
    /** How far a solid turns about its origin on the way, evenly: axis times angle (rad), at most 100.6 together; default zero. */
    float turn[3];
    /** Not used; 0. */
    uint32_t reserved;
} LsCastDef;

/** Where a cast first meets a shape. The layout of this struct never changes. */
typedef struct LsCastHit {
    /** The shape that is met; null if nothing is. */
    struct LsShape shape;
    /** Its body. */
    struct LsBody body;
    /** Where (m), on the surface of the shape that is met; where a ray begins, if that is inside a solid. */
    double point[3];
    /**
     * Outward unit normal of that surface; where a solid overlaps it from the start, the shortest way out. Of a ray that begins
     * inside a solid, against the ray.
     */
    float normal[3];
    /** Part of a compound that is met; LS_NO_INDEX of any other shape. */
    uint32_t part;
    /** How far along the path (m); 0 where the two overlap or touch from the start. */
    double distance;
    /** The same as a fraction of the whole way, 0 to 1: it tells how far a turn has got. */
    double fraction;
    /** How deep a solid overlaps the shape from the start, along the normal (m); else 0. */
    double depth;
    /**
     * Triangle of a mesh that is met, as the host numbered them, or of a height field: 2 * (row * (columns - 1) + column) for
     * the triangle at the cell's own height, and 1 more for the one across. LS_NO_INDEX of any other shape.
     */
    uint32_t triangle;
    /** Not used; 0. */
    uint32_t reserved;
} LsCastHit;

/** How far two shapes are apart, or how deep they overlap. The layout of this struct never changes. */
typedef struct LsShapeDistance {
    /** The first shape; null if there is none. */
    struct LsShape shape_a;
    /** The second shape; null from ls_world_nearest_shape_get, whose second shape is not one of the world's. */
    struct LsShape shape_b;
    /** World position of the nearest point of the first, or of its deepest where they overlap (m). */
    double point_a[3];
    /** World position of the nearest point of the second, or of its deepest (m). */
    double point_b[3];
    /** Distance (m); negative is the least depth by which they overlap. */
    double distance;
    /** Unit vector from the first to the second: moving the second along it by the depth parts them. */
    float normal[3];
    /** Part of a compound that the first point is on; LS_NO_INDEX of any other shape. */
    uint32_t part_a;
    /** The same of the second point. */
    uint32_t part_b;
    /** Triangle of a mesh or height field that the first point is on, numbered as in LsCastHit; LS_NO_INDEX of any other shape. */
    uint32_t triangle_a;
    /** The same of the second point. */
    uint32_t triangle_b;
    /** Not used; 0. */
    uint32_t reserved;
} LsShapeDistance;

/** A half-line of some length. The layout of this struct never changes. */
typedef struct LsRay {
    /** Where it begins (m). */
    double origin[3];
    /** Unit direction; up to 1 % off unit length is normalised, more is refused. */
    float direction[3];
    /** How far it goes (m), 0 to 1e7. */
    float length;
} LsRay;

/** Where a ray or a swept shape first meets a shape. The layout of this struct never changes. */
typedef struct LsRayHit {
    /** The shape that is met; null if nothing is. */
    struct LsShape shape;
    /** Its body. */
    struct LsBody body;
    /** Where (m), on the surface of the shape that is met. */
    double point[3];
    /**
     * Outward unit normal of that surface; where a solid overlaps it from the start, the shortest way out. Of a ray that begins
     * inside a solid, against the ray.
     */
    float normal[3];
    /** How far along the ray or sweep (m); 0 where the two overlap or touch from the start. */
    float distance;
} LsRayHit;

/** The nearest point of a shape to a point. The layout of this struct never changes. */
typedef struct LsNearestPoint {
    /** The shape; null if there is none. */
    struct LsShape shape;
    /** Its body. */
    struct LsBody body;
    /** Its nearest point (m): the point asked about, if that lies inside. */
    double point[3];
    /** How far that is (m); 0 inside. */
    float distance;
    /** Not used; 0. */
    uint32_t reserved;
} LsNearestPoint;

/**
 * Draws a line; given in an LsDraw.
 *
 * The drawing callbacks are called on the thread that calls ls_world_draw, under its own floating-point settings. They must
 * return normally (no exception, no longjmp). Inside them reads work, edits of any world return LS_ERROR_WORLD_LOCKED.
 * @param from   three doubles (m), valid during the call
 * @param to     three doubles (m), valid during the call
 * @param color  0xRRGGBB
 * @param user   as given in the LsDraw
 */
typedef void (*LsDrawLineCallback)(const double *from, const double *to, uint32_t color, void *user);

/**
 * Draws a triangle, counter-clockwise seen from outside where it has an outside; given in an LsDraw, see LsDrawLineCallback.
 * @param corners  nine doubles, three a corner (m), valid during the call
 * @param color    0xRRGGBB
 * @param user     as given in the LsDraw
 */
typedef void (*LsDrawTriangleCallback)(const double *corners, uint32_t color, void *user);

/**
 * Draws a short text; given in an LsDraw, see LsDrawLineCallback.
 * @param at     three doubles (m), valid during the call
 * @param text   UTF-8, valid during the call
 * @param color  0xRRGGBB
 * @param user   as given in the LsDraw
 */
typedef void (*LsDrawTextCallback)(const double *at, const char *text, uint32_t color, void *user);

/** What is drawn, how, and by whom. Fill it with ls_draw_init first. */
typedef struct LsDraw {
    /** Size of this struct in the host, set by ls_draw_init. */
    uint32_t struct_size;
    /** Bit set of LS_DRAW_ constants; default LS_DRAW_SHAPES | LS_DRAW_JOINTS. */
    uint32_t layers;
    /** Draws lines; NULL, the default, for none. */
    LsDrawLineCallback line;
    /** Draws triangles; NULL, the default, for none. */
    LsDrawTriangleCallback triangle;
    /** Draws texts; NULL, the default, for none. */
    LsDrawTextCallback text;
    /** Handed back to the callbacks; default NULL. */
    void *user;
    /** Length of a force's line (m/N), >= 0; default 0.001. */
    float force_scale;
    /** Length of a velocity's line (s), >= 0; default 0.1. */
    float velocity_scale;
    /** Length of the axes of a joint frame and size of a contact point's cross (m), > 0; default 0.1. */
    float mark_size;
    /** Not 0: only what lies within radius of center is drawn; default 0. */
    uint32_t only_near;
    /** Middle of what is drawn (m); default 0, 0, 0. */
    double center[3];
    /** How far from the middle things are drawn (m), >= 0; default 0. */
    double radius;
} LsDraw;

/**
 * Takes the next bytes of a recording; given to ls_world_recording_start.
 *
 * Called on the thread whose call is recorded, under its own floating-point settings, while the world is held: inside it every
 * call with that world returns LS_ERROR_WORLD_BUSY. It must return normally (no exception, no longjmp).
 * @param data  valid during the call
 * @param size  number of bytes
 * @param user  as given to ls_world_recording_start
 * @return 0; anything else ends the recording
 */
typedef int32_t (*LsRecordCallback)(const void *data, size_t size, void *user);

/** What a replay has done. Later versions append fields. */
typedef struct LsReplay {
    /** Calls read, those included that had been refused. */
    uint64_t calls;
    /** Calls that had been refused; they changed nothing and are not made again. */
    uint64_t refused;
    /** Steps taken. */
    uint64_t steps;
    /** 1 if something came out otherwise than recorded: nothing was played after that. Else 0, and so are the fields of it below. */
    uint32_t diverged;
    /** 1 if the recording ends in the middle of a call, as after a crash; else 0. */
    uint32_t cut_short;
    /** Number of the call that differs, from 0. */
    uint64_t call;
    /** Steps taken when it was made, itself included. */
    uint64_t step;
    /** What was recorded: the hash of the state, or what the call returned. */
    uint64_t recorded;
    /** What came out now. */
    uint64_t found;
    /** 1 if the two are hashes of the state, 0 if they are what the call returned. */
    uint32_t in_state;
    /** Not used; 0. */
    uint32_t reserved;
    /** Name of the call that differs, without "ls_", in words of the library; ends with a zero. */
    char method[40];
} LsReplay;

/** What a joint does at the end of the last step. Later versions append fields. */
typedef struct LsJointState {
    /** Coordinate of the free axis: angle, turns counted (rad), translation or distance (m); 0 for other kinds. */
    float position;
    /** Its rate (rad/s or m/s). */
    float velocity;
    /** Force that the joint exerts on body B at its point, world axes, mean over the step (N). */
    float force[3];
    /** Torque that the joint exerts on body B about its point, world axes, mean over the step (N m). */
    float torque[3];
    /** Distance between the two joint points beyond what the joint allows (m). */
    float gap;
    /**
     * Force (N) or torque (N m) on body B along the free axis, mean over the step: what motor, friction, spring, stops at limits and a
     * distance that is held come to. 0 for kinds without a coordinate; of these torque has all.
     */
    float effort;
} LsJointState;

/** One axis of a joint at the end of the last step. Later versions append fields. */
typedef struct LsJointAxisState {
    /** Its coordinate: angle, turns counted (rad), translation or distance (m). */
    float position;
    /** Rate of the coordinate (rad/s or m/s). */
    float velocity;
    /** Force (N) or torque (N m) on body B along the axis, mean over the step: all that acts there. */
    float effort;
    /** That of the motor alone (N or N m). */
    float motor;
} LsJointAxisState;

/** The verdict on a body at the end of the last step. The layout of this struct never changes. */
typedef struct LsSupport {
    /** LS_SUPPORT_ constant; the first three, and LS_SUPPORT_BRACED, mean that the body is held up. */
    int32_t verdict;
    /**
     * How far its centre of mass lies inside the hull of its supporting contacts, seen along gravity (m): negative outside,
     * minus infinity without supporting contacts.
     */
    float margin;
} LsSupport;

/** A body that gained or lost its support in a step. The layout of this struct never changes. */
typedef struct LsSupportChange {
    /** The body. */
    struct LsBody body;
    /** The word its host gave it. */
    uint64_t user_word;
    /** 1 if it is supported now, else 0. */
    uint32_t supported;
    /** Not used; 0. */
    uint32_t reserved;
} LsSupportChange;

/** Whether a kind of bound is derived, and its give. The layout of this struct never changes. */
typedef struct LsBoundKindDef {
    /** Not 0: such bounds are derived; default 1. */
    uint32_t enabled;
    /** Give where the distance would exceed the upper bound; default none. */
    struct LsSoftness upper;
    /** Give where the distance would fall below the lower bound; default none. */
    struct LsSoftness lower;
} LsBoundKindDef;

/** What a world derives from its joints. Fill it with ls_long_range_def_init first. */
typedef struct LsLongRangeDef {
    /** Size of this struct in the host, set by ls_long_range_def_init. */
    uint32_t struct_size;
    /** Not 0: bounds are derived; default 1. */
    uint32_t enabled;
    /** Bounds from static and kinematic attachments to what hangs on them. */
    struct LsBoundKindDef attachment;
    /** Bounds between bodies that are free. */
    struct LsBoundKindDef hierarchy;
    /** Levels of the hierarchy, 1 to 16; 0 (the default) for as many as the joints ask for. */
    uint32_t levels;
    /** Not used; 0. */
    uint32_t reserved;
    /** Not 0: bounds asked for with ls_world_soft_bound_set act; default 1. */
    uint32_t soft;
    /** Not 0: bodies that rigid fixed joints connect move as one, see ls_body_union_get; default 1. */
    uint32_t unions;
    /** Not 0: chains of hinges with parallel axes are kept in one plane; default 1. */
    uint32_t plane_position;
    /** Not 0: the axes of such chains are kept parallel; default 1. */
    uint32_t plane_axis;
} LsLongRangeDef;

/**
 * The greatest distance that a chain of joints leaves its two ends, taken as a soft lower bound: a spring that stretches it. The
 * layout of this struct never changes.
 */
typedef struct LsSoftBound {
    /** Factor on the greatest distance at which the spring is at rest, above 0 and up to 1. */
    float share;
    /** Spring and damper; its compliance must not be 0. */
    struct LsSoftness softness;
} LsSoftBound;

/** A bound on the distance of two joints, as the last step left it. The layout of this struct never changes. */
typedef struct LsBound {
    /** Joint at its near end: that of the attachment, where it has one. */
    struct LsJoint near_joint;
    /** Joint at its far end. */
    struct LsJoint far_joint;
    /** Its near and its far point, world coordinates (m). */
    double points[2][3];
    /** LS_BOUND_ constant. */
    int32_t kind;
    /** Level in the hierarchy; 0 for other kinds. */
    uint32_t level;
    /** Distance of the two points (m). */
    float distance;
    /** Greatest distance (m). */
    float upper;
    /** Least distance (m), 0 for none. */
    float lower;
    /** Tension, mean over the last step (N); negative where the lower bound pushes. */
    float tension;
    /** 1 if it had anything to do in the last step, else 0. */
    uint32_t active;
    /** Not used; 0. */
    uint32_t reserved;
} LsBound;

/** The common plane of a chain of hinges, as the last step left it. The layout of this struct never changes. */
typedef struct LsPlane {
    /** The chain's joint of the lowest slot: it names the chain while both last. */
    struct LsJoint joint;
    /** The plane's point nearest to the middle of the chain (m). */
    double point[3];
    /** Unit normal, along the axes of the hinges. */
    float normal[3];
    /** Distance from the point of the member that is farthest from it (m). */
    float radius;
    /** Root of the mean square of the distances by which members are off the plane (m). */
    float deviation;
    /** Number of members: bodies, and rigid unions that count as one. */
    uint32_t members;
    /** 1 if a hinge to something fixed gives the plane, else 0. */
    uint32_t anchored;
    /** Not used; 0. */
    uint32_t reserved;
} LsPlane;

/** A chain of joints as the last step left it. Later versions append fields. */
typedef struct LsChainState {
    /** Links: bodies between two joints. */
    uint32_t link_count;
    /** Length at rest: the sum of its links (m). */
    float rest_length;
    /** Length now: with what each joint is apart, those at both ends among them (m). */
    float length;
    /** Fraction of its length at rest by which it is longer than that. */
    float stretch;
    /** Greatest tension of a link, mean over the last step (N); negative where all are pushed together. */
    float greatest_tension;
} LsChainState;

/** A link of a chain: a body between two joints. The layout of this struct never changes. */
typedef struct LsChainLink {
    /** The body; of a union, the member at the first joint. */
    struct LsBody body;
    /** The joints at its two ends. */
    struct LsJoint joints[2];
    /** Distance of the two joints on it (m). */
    float length;
    /** Force that the two pull it apart with, mean over the last step (N); negative where they push. */
    float tension;
} LsChainLink;

/** Bodies that rigid fixed joints make one, as the last step left them. The layout of this struct never changes. */
typedef struct LsUnion {
    /** Its dynamic body that was made first: it names the union while both last. Null for no union. */
    struct LsBody lead;
    /** Number of its dynamic bodies; 0 for no union. */
    uint32_t members;
    /** Number of fixed joints that it is made of. */
    uint32_t joints;
    /** World position of the centre of mass of its dynamic bodies (m). */
    double center[3];
    /** Velocity of the centre of mass (m/s). */
    float linear_velocity[3];
    /** Angular velocity (rad/s). */
    float angular_velocity[3];
    /** Mass of its dynamic bodies (kg). */
    float mass;
    /** 1 if static or kinematic bodies, or the world, hold it, else 0. */
    uint32_t anchored;
    /** Worst distance by which its joints contradict one another (m). */
    float distance_residual;
    /** Worst angle by which its joints contradict one another (rad). */
    float angle_residual;
} LsUnion;

/** A joint that broke in a step. It is gone: its handle is stale. The layout of this struct never changes. */
typedef struct LsJointBreak {
    /** The joint that was. */
    struct LsJoint joint;
    /** The word its host gave it. */
    uint64_t user_word;
    /** Its first body; null is the world. */
    struct LsBody body_a;
    /** Its second body; null is the world. */
    struct LsBody body_b;
    /** Where it was (m). */
    double point[3];
    /** Number of the step. */
    uint64_t step;
    /** Mean force on B over its window, world axes (N). */
    float force[3];
    /** Mean torque on B about its point, world axes (N m). */
    float torque[3];
    /** Its load as a fraction of the limit that it broke at; above 1 if by load. */
    float share;
    /** LS_STRENGTH_ constant: that limit. */
    int32_t limit;
    /** LS_BREAK_ constant: why it broke. */
    int32_t cause;
    /** Not used; 0. */
    uint32_t reserved;
} LsJointBreak;

/**
 * Receives the joints that broke in a step, one call each, in the order of ls_world_joint_breaks_get.
 *
 * Called after the solve on the thread that steps, under its own floating-point settings. It must return normally (no
 * exception, no longjmp). Inside it, reads of the world work, on other threads too; edits return LS_ERROR_WORLD_LOCKED.
 * @param world   the world that steps
 * @param broken  the joint and its load, valid during the call
 * @param user    as given to ls_world_break_callback_set
 */
typedef void (*LsBreakCallback)(struct LsWorld world, const struct LsJointBreak *broken, void *user);

/**
 * A rigid union, which is the dynamic bodies that fixed joints connect, that fell into pieces in a step, or lost its anchor. The
 * layout of this struct never changes.
 */
typedef struct LsSplit {
    /** Its member of the lowest slot, which is in the first piece too. */
    struct LsBody first_body;
    /** Its centre of mass at the end of the step (m). */
    double center[3];
    /** Number of the step. */
    uint64_t step;
    /** Number of its members. */
    uint32_t body_count;
    /** Its mass (kg). */
    float mass;
    /** Velocity of its centre of mass (m/s). */
    float linear_velocity[3];
    /** 1 if a fixed joint tied it to the world or to a body that is not dynamic, else 0. */
    uint32_t anchored;
    /** Its first piece in the array of ls_world_pieces_get. */
    uint32_t first_piece;
    /** Number of its pieces. */
    uint32_t piece_count;
} LsSplit;

/**
 * Receives the unions that fell into pieces in a step, one call each, in the order of ls_world_splits_get, after all broken joints.
 *
 * Called like LsBreakCallback; ls_world_pieces_get and ls_world_piece_bodies_get work inside it.
 * @param world  the world that steps
 * @param split  the union, valid during the call
 * @param user   as given to ls_world_split_callback_set
 */
typedef void (*LsSplitCallback)(struct LsWorld world, const struct LsSplit *split, void *user);

/** What is left of a union: a smaller one, or a single body. The layout of this struct never changes. */
typedef struct LsPiece {
    /** Its member of the lowest slot. */
    struct LsBody first_body;
    /** Its centre of mass at the end of the step (m). */
    double center[3];
    /** Its first member in the array of ls_world_piece_bodies_get. */
    uint32_t first_member;
    /** Number of its members. */
    uint32_t body_count;
    /** Its mass (kg). */
    float mass;
    /** Velocity of its centre of mass (m/s). */
    float linear_velocity[3];
    /** Angular velocity: that of a rigid body with its angular momentum (rad/s). */
    float angular_velocity[3];
    /** 1 if a fixed joint still ties it to the world or to a body that is not dynamic, else 0. */
    uint32_t anchored;
    /** 1 if the union had an anchor and this piece has none, else 0. */
    uint32_t cut_loose;
    /** Not used; 0. */
    uint32_t reserved;
} LsPiece;

/** What a joint bears at present. Later versions append fields. */
typedef struct LsJointStress {
    /** Mean force on B over the window, axes of the joint's frame on A (N); of a distance joint, x along the line from its point on A to that on B. */
    float force[3];
    /** Mean torque on B about the joint's point, axes of the joint's frame on A (N m). */
    float torque[3];
    /** Its load as a fraction of the nearest limit: 1 breaks; 0 without limits. */
    float share;
    /** LS_STRENGTH_ constant: that limit. */
    int32_t limit;
    /** Its wear, a fraction: 1 breaks. */
    float damage;
} LsJointStress;

/** What bonds the cells of a solid. The layout of this struct never changes. */
typedef struct LsBondMaterial {
    /** Greatest tensile stress (N/m^2, which is Pa), >= 0. */
    float tension;
    /** Greatest compressive stress (N/m^2, which is Pa), >= 0. */
    float compression;
    /** Greatest shear stress (N/m^2, which is Pa), >= 0. */
    float shear;
    /** Time over which loads are averaged (s), above 0, at most 10. */
    float window;
    /** Not 0: loads below the limits wear bonds out, as in LsStrength. */
    uint32_t wears;
    /** Fraction of a limit from which a bond wears, 0 to below 1; read if wears. */
    float damage_from;
    /** Time after which a new bond at its limit is worn out (s), > 0; read if wears. */
    float damage_time;
    /** Time in which damage halves (s), > 0, INFINITY if it stays; read if wears. */
    float damage_half_life;
} LsBondMaterial;

/** Everything a stream starts with. Fill it with ls_stream_def_init first. */
typedef struct LsStreamDef {
    /** Size of this struct in the host, set by ls_stream_def_init. */
    uint32_t struct_size;
    /** A frame every so many steps, at least 1; default 1. */
    uint32_t every;
    /** What readers look for: 1 to 63 letters, digits, '_', '-' and '.'; NULL, the default, for "world". */
    const char *name;
    /**
     * Room in which publishers and readers find each other, named alike; NULL, the default, for that of all who ask for none.
     * Only processes of the same user meet, whatever the room.
     */
    const char *domain;
    /** LS_STREAM_LAYER_ bits: what frames hold besides motion; default 0. */
    uint32_t layers;
    /** Most readers at a time, 1 to 64; default 8. Each costs memory for four frames. */
    uint32_t readers;
    /** Bodies to have room for from the start; default 0, for those that are there. More are found room for when they come. */
    uint32_t body_capacity;
    /** Not 0: each frame carries the hash of the world's state; default 1. */
    uint32_t state_hash;
} LsStreamDef;

/** Names a stream. Passed by value; any value is safe. */
typedef struct LsStream {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsStream;

/** What a stream has done so far. Later versions append fields. */
typedef struct LsStreamStats {
    /** Frames published. */
    uint64_t frames;
    /** Messages published on the cold channel. */
    uint64_t records;
    /** Messages that could not be placed; a reader that is late loses frames without being counted here. */
    uint64_t dropped;
    /** Bytes published. */
    uint64_t bytes;
    /** What the last publication took (s). */
    double seconds;
} LsStreamStats;

/** A stream that can be read. The layout of this struct never changes. */
typedef struct LsStreamSource {
    /** Its name, closed by a zero. */
    char name[64];
    /** Number of the process that publishes it. */
    uint32_t process;
    /** Number of the stream in that process. */
    uint32_t number;
    /** Its schema; this library reads LS_STREAM_SCHEMA. */
    uint32_t schema;
    /** Not used; 0. */
    uint32_t reserved;
} LsStreamSource;

/** Everything a reader starts with. Fill it with ls_stream_reader_def_init first. */
typedef struct LsStreamReaderDef {
    /** Size of this struct in the host, set by ls_stream_reader_def_init. */
    uint32_t struct_size;
    /** Not used; 0. */
    uint32_t reserved;
    /** Name of the stream; NULL, the default, for any. It need not be there yet. */
    const char *name;
    /** Room of the publisher; see LsStreamDef. */
    const char *domain;
    /** File of a recording to read in place of a stream; NULL, the default, for none. */
    const char *recording;
} LsStreamReaderDef;

/** Names a reader of a stream. Passed by value; any value is safe. */
typedef struct LsStreamReader {
    /** Opaque bits, zero for none; they may be stored, compared, and handed back later. */
    uint64_t id;
} LsStreamReader;

/** What every message begins with. */
typedef struct LsStreamHeader {
    /** LS_STREAM_MAGIC. */
    uint64_t magic;
    /** LS_STREAM_SCHEMA. */
    uint32_t schema;
    /** Bytes of this header; sections begin after them. */
    uint32_t header_size;
    /** Hash of the names, offsets and sizes of all fields as the publisher was compiled. */
    uint64_t layout_hash;
    /** Bytes of the message, this header included. */
    uint64_t length;
    /** A number that differs between any two lives of a publisher. */
    uint64_t session;
    /** Number of the message on its channel, from 1, without gaps. */
    uint64_t sequence;
    /** Number of the step that it is about. */
    uint64_t step;
    /** Simulated time at the end of that step (s). */
    double time;
    /** Hash of the poses and velocities of all bodies of the world, as ls_world_state_hash_get gives it; see flags. */
    uint64_t state_hash;
    /** Hash of all bytes after this header. */
    uint64_t content_hash;
    /** Messages that the publisher could not place so far. */
    uint64_t dropped;
    /** LS_STREAM_CHANNEL_ constant. */
    uint32_t channel;
    /** Number of sections. */
    uint32_t section_count;
    /** Bodies in the world. */
    uint32_t body_count;
    /** Shapes in the world. */
    uint32_t shape_count;
    /** Joints in the world. */
    uint32_t joint_count;
    /** LS_STREAM_ message flags. */
    uint32_t flags;
    /** How often the whole scene has begun to be told. */
    uint64_t cycle;
    /** When it was published, by the system's clock: nanoseconds since 1970 began. */
    uint64_t clock;
} LsStreamHeader;

/** What a reader found. Later versions append fields. */
typedef struct LsStreamPoll {
    /** LS_STREAM_FRAME, LS_STREAM_NOTHING, LS_STREAM_GONE or LS_STREAM_END. */
    int32_t status;
    /** 1 for the first frame of a publisher that has begun, or begun anew; else 0. */
    uint32_t is_first;
    /** 1 if the whole world has been told and nothing was missed since; else 0. */
    uint32_t is_complete;
    /** Not used; 0. */
    uint32_t reserved;
    /** Frames that were published since the last one and could not be read any more. */
    uint64_t lost_frames;
    /** Messages of the cold channel that were missed. */
    uint64_t lost_records;
    /** Header of the last frame; all zero before the first. */
    struct LsStreamHeader frame;
} LsStreamPoll;

/** The world that a stream is of. */
typedef struct LsStreamWorld {
    /** Bytes of the stream's name in UTF-8, then zeroes. */
    uint8_t name[64];
    /** Number of the process that steps it. */
    uint64_t process;
    /** Gravity (m/s^2). */
    float gravity[3];
    /** Substeps a step. */
    uint32_t substeps;
    /** Sweeps a substep. */
    uint32_t iterations;
    /** 1 if the support analysis is on, else 0. */
    uint32_t support;
    /** LS_STREAM_LAYER_ bits of what its frames hold besides motion. */
    uint32_t layers;
    /** Every how many steps a frame is published. */
    uint32_t every;
} LsStreamWorld;

/** A body as it was when the record was written. It replaces what was known of the body. */
typedef struct LsStreamBody {
    /** The body. */
    uint64_t body;
    /** The word its host gave it. */
    uint64_t user_word;
    /** Rigid union that it is a member of; 0 for none. */
    uint64_t union_id;
    /** Step after which it stood here. */
    uint64_t step;
    /** Position of its frame (m). */
    double position[3];
    /** Rotation of its frame, unit quaternion: x, y, z, w. */
    float rotation[4];
    /** Velocity of its centre of mass (m/s). */
    float linear_velocity[3];
    /** Angular velocity, world axes (rad/s). */
    float angular_velocity[3];
    /** LS_STREAM_BODY_ flags. */
    uint32_t flags;
    /** LS_BODY_ constant. */
    int32_t kind;
    /** Mass (kg); 0 unless it is dynamic. */
    float mass;
    /** LS_SUPPORT_ constant, if the flags say that support is known. */
    int32_t support;
    /** How far its centre of mass lies inside the hull of its supporting contacts (m); 0 where that is not known or infinite. */
    float support_margin;
    /** Load that rests on it (N), if known. */
    float support_load;
} LsStreamBody;

/** A shape of a body, or one part of a compound shape. */
typedef struct LsStreamShape {
    /** The shape. */
    uint64_t shape;
    /** Its body. */
    uint64_t body;
    /** The word its host gave it. */
    uint64_t user_word;
    /** LS_SHAPE_ constant, never LS_SHAPE_COMPOUND: hulls, meshes and height fields come with triangles (LsStreamGeometry). */
    int32_t kind;
    /** Number of the part, from 0. */
    uint32_t part;
    /** Number of parts, 1 unless the shape is a compound. */
    uint32_t part_count;
    /** Not used; 0. */
    uint32_t reserved;
    /** Position in the body's frame (m). */
    float position[3];
    /** Rotation in the body's frame, unit quaternion: x, y, z, w. */
    float rotation[4];
    /** Ball: radius. Box: half extents. Capsule, cylinder and cone, along y: half height, radius. Half-space: normal. (m) */
    float size[3];
    /** Coefficient of friction. */
    float friction;
    /** Coefficient of restitution. */
    float restitution;
} LsStreamShape;

/** A joint as it was when the record was written. */
typedef struct LsStreamJoint {
    /** The joint. */
    uint64_t joint;
    /** The word its host gave it. */
    uint64_t user_word;
    /** First body; 0 for the world. */
    uint64_t body_a;
    /** Second body; 0 for the world. */
    uint64_t body_b;
    /** Joint frame on body A, in its frame, or in the world's (m). */
    double position_a[3];
    /** Joint frame on body B, in its frame, or in the world's (m). */
    double position_b[3];
    /** Rotation of the joint frame on body A, unit quaternion: x, y, z, w. */
    float rotation_a[4];
    /** Rotation of the joint frame on body B, unit quaternion: x, y, z, w. */
    float rotation_b[4];
    /** LS_JOINT_ constant. */
    int32_t kind;
    /** LS_STREAM_JOINT_ flags. */
    uint32_t flags;
    /** Force above which it is overloaded (N); 0 for no limit. */
    float break_force;
    /** Torque above which it is overloaded (N m); 0 for no limit. */
    float break_torque;
} LsStreamJoint;

/** A point of a contact in a stream. */
typedef struct LsStreamContactPoint {
    /** Halfway between the two surfaces (m). */
    double position[3];
    /** Distance of the surfaces along the normal (m), negative if they overlap. */
    float separation;
    /** Force along the normal in the last substep (N), >= 0. */
    float normal_force;
} LsStreamContactPoint;

/** A contact between two bodies after a step. */
typedef struct LsStreamContact {
    /** One body. */
    uint64_t body_a;
    /** The other. */
    uint64_t body_b;
    /** Unit normal, from A to B. */
    float normal[3];
    /** Number of points, 1 to 4. */
    uint32_t point_count;
    /** Friction on B, mean over the last substep (N). */
    float friction_force[3];
    /** Not used; 0. */
    uint32_t reserved;
    /** The points; those beyond point_count are zero. */
    struct LsStreamContactPoint points[4];
} LsStreamContact;

/** What a joint carries after a step. */
typedef struct LsStreamJointLoad {
    /** The joint. */
    uint64_t joint;
    /** Force that it carries, mean over the step (N). */
    float force;
    /** Torque that it carries, mean over the step (N m). */
    float torque;
    /**
     * Fraction of its limit: the greatest of force / break_force, torque / break_torque and, if it can break, its mean load over
     * the limit that it is nearest to; 0 for a joint without limits.
     */
    float share;
    /** Distance between the joint points beyond what the joint allows (m). */
    float gap;
} LsStreamJointLoad;

/** A long-range bound after a step. */
typedef struct LsStreamBound {
    /** Joint at its near end. */
    uint64_t near_joint;
    /** Joint at its far end. */
    uint64_t far_joint;
    /** The point at its near end (m). */
    double near_point[3];
    /** The point at its far end (m). */
    double far_point[3];
    /** Distance of the two points (m). */
    float distance;
    /** Greatest distance (m). */
    float upper;
    /** Least distance (m), 0 for none. */
    float lower;
    /** Tension, mean over the step (N); negative where the lower bound pushes. */
    float tension;
    /** LS_BOUND_ constant. */
    uint32_t kind;
    /** Level in the hierarchy; 0 for other kinds. */
    uint32_t level;
    /** 1 if it had anything to do in the step, else 0. */
    uint32_t active;
    /** Not used; 0. */
    uint32_t reserved;
} LsStreamBound;

/** The common plane of a chain of hinges after a step. */
typedef struct LsStreamPlane {
    /** The chain's joint of the lowest slot: it names the chain while both last. */
    uint64_t chain;
    /** The plane's point nearest to the middle of the chain (m). */
    double point[3];
    /** Unit normal, along the axes of the hinges. */
    float normal[3];
    /** Distance from the point of the member that is farthest from it (m). */
    float radius;
} LsStreamPlane;

/** Something that happened in a step. */
typedef struct LsStreamEvent {
    /** The step. */
    uint64_t step;
    /** What it happened to: see the kinds. */
    uint64_t a;
    /** And what else. */
    uint64_t b;
    /** The word that the host gave `a`. */
    uint64_t user_word;
    /** LS_STREAM_EVENT_ constant. */
    uint32_t kind;
    /** Not used; 0. */
    uint32_t reserved;
    /** Numbers as the kinds say, (N) and (N m). */
    float values[4];
} LsStreamEvent;

/** A joint that broke. It is gone: its handle means nothing any more. */
typedef struct LsStreamBreak {
    /** The step. */
    uint64_t step;
    /** The joint that was. */
    uint64_t joint;
    /** The word its host gave it. */
    uint64_t user_word;
    /** Its first body; 0 for the world. */
    uint64_t body_a;
    /** Its second body; 0 for the world. */
    uint64_t body_b;
    /** Where it was (m). */
    double point[3];
    /** Mean force on B over its window, world axes (N). */
    float force[3];
    /** Mean torque on B about its point, world axes (N m). */
    float torque[3];
    /** Its load as a fraction of the limit that it broke at; above 1 if by load. */
    float share;
    /** LS_STRENGTH_ constant: that limit. */
    int32_t limit;
    /** LS_BREAK_ constant: why it broke. */
    int32_t cause;
    /** Not used; 0. */
    uint32_t reserved;
} LsStreamBreak;

/** A piece of a rigid union that fell apart, or lost its anchor. Which bodies are of it is told of them: LsStreamBody.union_id. */
typedef struct LsStreamPiece {
    /** The step. */
    uint64_t step;
    /** The union's member of the lowest slot: the same for all pieces of one union. */
    uint64_t of_body;
    /** The piece's member of the lowest slot. */
    uint64_t first_body;
    /** Its centre of mass at the end of the step (m). */
    double center[3];
    /** Velocity of its centre of mass (m/s). */
    float linear_velocity[3];
    /** Angular velocity: that of a rigid body with its angular momentum (rad/s). */
    float angular_velocity[3];
    /** Its mass (kg). */
    float mass;
    /** Number of its bodies. */
    uint32_t body_count;
    /** 1 if a fixed joint ties it to the world, or to a body that is not dynamic, else 0. */
    uint32_t anchored;
    /** 1 if it has lost its anchor, else 0. */
    uint32_t cut_loose;
} LsStreamPiece;

/** A recording as a whole. Later versions append fields. */
typedef struct LsStreamRecording {
    /** First step of which there is a frame. */
    uint64_t first_step;
    /** Last step of which there is a frame. */
    uint64_t last_step;
    /** Number of frames. */
    uint64_t frames;
    /** First byte of what is missing or damaged; 0 if nothing is. */
    uint64_t offset;
    /** LS_STREAM_RECORDING_ constant. */
    int32_t end;
    /** Not used; 0. */
    uint32_t reserved;
} LsStreamRecording;

/** What every section of a message begins with. */
typedef struct LsStreamSection {
    /** LS_STREAM_SECTION_ constant; one that a reader does not know is skipped. */
    uint32_t kind;
    /** Bytes from one record to the next. */
    uint32_t stride;
    /** Number of records. */
    uint32_t count;
    /** Not used; 0. */
    uint32_t flags;
    /** Bytes of the records, padding to a multiple of 8 included. */
    uint64_t length;
    /** Not used; 0. */
    uint64_t reserved;
} LsStreamSection;

/** A body that moved in a step. */
typedef struct LsStreamMotion {
    /** The body. */
    uint64_t body;
    /** The word its host gave it. */
    uint64_t user_word;
    /** Rigid union that it is a member of; 0 for none. */
    uint64_t union_id;
    /** Position of its frame (m). */
    double position[3];
    /** Rotation of its frame, unit quaternion: x, y, z, w. */
    float rotation[4];
    /** Velocity of its centre of mass (m/s). */
    float linear_velocity[3];
    /** Angular velocity, world axes (rad/s). */
    float angular_velocity[3];
    /** LS_STREAM_BODY_ flags. */
    uint32_t flags;
    /** Not used; 0. */
    uint32_t reserved;
} LsStreamMotion;

/** Some triangles of a shape that has no simple form: the whole may come in several of these. */
typedef struct LsStreamGeometry {
    /** The shape. */
    uint64_t shape;
    /** Number of the shape's part. */
    uint32_t part;
    /** Vertices of the whole. */
    uint32_t vertex_total;
    /** Triangles of the whole. */
    uint32_t triangle_total;
    /** First vertex of these. */
    uint32_t first_vertex;
    /** Number of vertices that follow. */
    uint32_t vertex_count;
    /** First triangle of these. */
    uint32_t first_triangle;
    /** Number of triangles that follow the vertices, as three numbers of vertices of the whole each. */
    uint32_t triangle_count;
    /** Not used; 0. */
    uint32_t reserved;
} LsStreamGeometry;

/** A body, shape or joint that is no more. */
typedef struct LsStreamGone {
    /** Its handle. */
    uint64_t id;
    /** Step before which it went. */
    uint64_t step;
} LsStreamGone;

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

/** Bytes that are no snapshot, of another version of the library, cut short or corrupted. */
#define LS_ERROR_INVALID_SNAPSHOT 23

/** A stream or a recording of another version. */
#define LS_ERROR_STREAM_INCOMPATIBLE 24

/** Bytes of a stream or a recording that make no sense. */
#define LS_ERROR_STREAM_CORRUPT 25

/** The system refuses shared memory or a file; the message says which, and why. */
#define LS_ERROR_STREAM_SYSTEM 26



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
 * Sets whether a mistake ends the process (abort) where it happens, after it was logged, so that a debugger stops there.
 *
 * @param level  LS_LOG_OFF, the default: never; LS_LOG_ERROR: when the library itself fails; LS_LOG_WARNING: also when a call is
 *               refused
 * @return LS_OK, LS_ERROR_INVALID_ENUM
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_abort_level_set(int32_t level);

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

/**
 * Sets who gives the library its memory: the first call that a host makes, before any other.
 *
 * @param allocator  read during the call; NULL for the system's own
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT (a function in it is NULL), LS_ERROR_NOT_APPLICABLE (the library holds memory already:
 *         ls_memory_get says how much)
 * Threads: one thread, while no other is inside the library. Callbacks: LS_ERROR_NOT_APPLICABLE.
 */
LsResult ls_allocator_set(const LsAllocator *allocator);

/**
 * Memory that the library holds.
 *
 * @param out   filled on LS_OK
 * @param size  sizeof *out as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_memory_get(LsMemory *out, size_t size);

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

/**
 * Fills a set of callbacks with none.
 *
 * @param callbacks  filled on LS_OK
 * @param size       sizeof *callbacks as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_callbacks_init(LsCallbacks *callbacks, size_t size);

/**
 * Sets who is told what each step did; at the start nobody is. The arrays that tell the same are there anyway.
 *
 * @param world      the world; any value is safe
 * @param callbacks  filled by ls_callbacks_init and changed as wanted; read during the call
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_callbacks_set(LsWorld world, const LsCallbacks *callbacks);

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
 * The definition that the world has now: as it was created, with what has been set since, which is gravity, effort, sleep,
 * thresholds of hits and of restitution, whether support is kept up, and all else that has a call to set it.
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
 * A body that the step would have given a state that is NaN or infinite, or a position more than 1e9 m from the origin, is quarantined
 * (ls_world_quarantined_bodies_get); the rest goes on.
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
 * How each articulation was solved in the last step: bodies that joints connect and that are solved at once. Islands that sleep
 * or are held, and joints that are left to sweeps alone, are not among them.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_articulations_get(LsWorld world, const LsArticulation **out, size_t *count);

/**
 * How each island with joints was solved in the last step, and why. Islands that sleep or are held, and those without joints, whose
 * contacts are swept, are not among them.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_islands_get(LsWorld world, const LsIsland **out, size_t *count);

/**
 * Pairs of shapes that began to press on each other in the last step: a force acts between them at its end, they have rebounded in
 * it, or their hit is told. Shapes that touch or overlap while nothing presses them together are not among them, nor those that met
 * slower than hit_threshold and press no more at the end of the step; ls_body_contacts_get lists both.
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
 * Pairs of shapes that ceased to press on each other in the last step.
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
 * Bodies that the last step would have given a state that is NaN or infinite, or a position more than 1e9 m from the origin. They
 * stay where they were, without contacts, until the host gives them a pose or velocity.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_quarantined_bodies_get(LsWorld world, const LsBody **out, size_t *count);

/**
 * Contacts of the last step whose shapes met faster than the world's hit_threshold, with the impulse.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_hits_get(LsWorld world, const LsHit **out, size_t *count);

/**
 * Joints that came to a stop of theirs in the last step: a limit that did not press before it presses now.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_joint_stops_get(LsWorld world, const LsJointStop **out, size_t *count);

/**
 * Shapes that began to overlap a sensor in the last step; of each pair, the sensor comes first.
 *
 * A sensor sees, at the end of each step, every shape of another body that its filter accepts and that is no sensor itself, unless
 * both bodies are static.
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_sensor_overlaps_begun_get(LsWorld world, const LsContactPair **out, size_t *count);

/**
 * Shapes that ceased to overlap a sensor in the last step, or of which either was destroyed since the step before it; of each
 * pair, the sensor comes first.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_sensor_overlaps_ended_get(LsWorld world, const LsContactPair **out, size_t *count);

/**
 * Everything that overlapped a sensor at the end of the last step; of each pair, the sensor comes first.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_sensor_overlaps_get(LsWorld world, const LsContactPair **out, size_t *count);

/**
 * Sets how much work a step does, from the next step on.
 *
 * @param world       the world; any value is safe
 * @param substeps    substeps a step, 1 to 256
 * @param iterations  sweeps a substep, 1 to 256
 * @return LS_OK, a world error, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_effort_set(LsWorld world, uint32_t substeps, uint32_t iterations);

/**
 * Sets how much work articulations may take, from the next step on.
 *
 * @param world     the world; any value is safe
 * @param settings  read during the call
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_articulation_settings_set(LsWorld world, const LsArticulationSettings *settings);

/**
 * Sets when bodies fall asleep; if they no longer may, all wake.
 *
 * @param world     the world; any value is safe
 * @param settings  read during the call; speeds (m/s, rad/s) and time (s), each >= 0
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_sleep_settings_set(LsWorld world, const LsSleepSettings *settings);

/**
 * Sets the approach speed above which contacts are listed by ls_world_hits_get.
 *
 * @param world  the world; any value is safe
 * @param speed  (m/s), >= 0; INFINITY for never
 * @return LS_OK, a world error, LS_ERROR_NOT_FINITE (NaN), LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_hit_threshold_set(LsWorld world, float speed);

/**
 * Sets the approach speed below which nothing bounces.
 *
 * @param world  the world; any value is safe
 * @param speed  (m/s), >= 0
 * @return LS_OK, a world error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_restitution_threshold_set(LsWorld world, float speed);

/**
 * Has the host's job system do the independent parts of a world's steps, in place of threads of its own. The bits of a step do not
 * depend on who does them.
 *
 * @param world     the world; any value is safe
 * @param callback  called by ls_world_step; NULL for the world's own threads, as many as it was created with
 * @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
 * @return LS_OK, a world error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_parallel_for_set(LsWorld world, LsParallelForCallback callback, void *user);

/**
 * Sets the functions that are told where a world's steps are; at the start there are none. The bits of a step do not depend on
 * them.
 *
 * @param world  the world; any value is safe
 * @param begin  told that a zone begins; NULL, as end, for none
 * @param end    told that a zone ends; NULL, as begin, for none
 * @param user   handed back to both; must stay valid until others are set or the world is destroyed
 * @return LS_OK, a world error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_profiler_set(LsWorld world, LsZoneCallback begin, LsZoneCallback end, void *user);

/**
 * Fills a query filter with defaults: every shape counts.
 *
 * @param filter  filled on LS_OK
 * @param size    sizeof *filter as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_query_filter_init(LsQueryFilter *filter, size_t size);

/**
 * Fills the definition of a cast with defaults: a ray of no length from the origin.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_cast_def_init(LsCastDef *def, size_t size);

/**
 * The first shape that a solid or a point meets on its way, with the part and the triangle that it meets.
 *
 * @param world   the world; any value is safe
 * @param def     filled by ls_cast_def_init and changed as wanted; read during the call
 * @param filter  which shapes count; NULL for all
 * @param out     filled on LS_OK; its shape is null if nothing is met
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_cast(LsWorld world, const LsCastDef *def, const LsQueryFilter *filter, LsCastHit *out);

/**
 * Every shape that a solid or a point meets on its way, nearest first, where it first meets it.
 *
 * @param world     the world; any value is safe
 * @param def       filled by ls_cast_def_init and changed as wanted; read during the call
 * @param filter    which shapes count; NULL for all
 * @param out       room for capacity hits, filled on LS_OK, nearest first; may be NULL if capacity is 0
 * @param capacity  number that fit
 * @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_cast_all(LsWorld world,
                           const LsCastDef *def,
                           const LsQueryFilter *filter,
                           LsCastHit *out,
                           size_t capacity,
                           size_t *count);

/**
 * How far two shapes of a world are apart, or how deep they overlap. Sensors and shapes of one body count too. Where a mesh
 * or a height field is overlapped, the depth is that of the triangle that is overlapped deepest.
 *
 * @param world  the world; any value is safe
 * @param a      the first; any value is safe
 * @param b      the second; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_APPLICABLE (both are half-spaces)
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_shape_distance_get(LsWorld world, LsShape a, LsShape b, LsShapeDistance *out);

/**
 * The shape nearest to a solid, or the one that it overlaps deepest: shape_a; shape_b is null.
 *
 * @param world         the world; any value is safe
 * @param shape         filled by ls_shape_def_init and changed as wanted; as in ls_world_shape_cast
 * @param pose          where it is; positions (m)
 * @param max_distance  how far to look (m), 0 to 1e7
 * @param filter        which shapes count; NULL for all
 * @param out           filled on LS_OK; its shape_a is null if there is none
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_nearest_shape_get(LsWorld world,
                                    const LsShapeDef *shape,
                                    const LsPose *pose,
                                    float max_distance,
                                    const LsQueryFilter *filter,
                                    LsShapeDistance *out);

/* Queries --------------------------------------------------------------------------------------------------------- */

/**
 * The first shape that a ray meets. A ray that begins inside a solid meets it at once.
 *
 * @param world   the world; any value is safe
 * @param ray     read during the call; lengths (m)
 * @param filter  which shapes count; NULL for all
 * @param out     filled on LS_OK; its shape is null if nothing is met
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_ray_cast(LsWorld world, const LsRay *ray, const LsQueryFilter *filter, LsRayHit *out);

/**
 * Every shape that a ray meets, nearest first, where the ray first meets it.
 *
 * @param world     the world; any value is safe
 * @param ray       read during the call; lengths (m)
 * @param filter    which shapes count; NULL for all
 * @param out       room for capacity hits, filled on LS_OK, nearest first; may be NULL if capacity is 0
 * @param capacity  number that fit
 * @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_ray_cast_all(LsWorld world,
                               const LsRay *ray,
                               const LsQueryFilter *filter,
                               LsRayHit *out,
                               size_t capacity,
                               size_t *count);

/**
 * The first shape that each of many rays meets; on the threads of the world, if it has more than one and the rays are many.
 *
 * @param world   the world; any value is safe
 * @param rays    count rays, read during the call; lengths (m)
 * @param count   number of rays; 0 is allowed
 * @param filter  which shapes count; NULL for all
 * @param out     room for count hits, filled on LS_OK; the shape of a hit is null if nothing is met
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_rays_cast(LsWorld world,
                            const LsRay *rays,
                            size_t count,
                            const LsQueryFilter *filter,
                            LsRayHit *out);

/**
 * The first shape that a solid meets on a straight path, without turning.
 *
 * @param world   the world; any value is safe
 * @param shape   filled by ls_shape_def_init and changed as wanted; its geometry is read during the call; a solid, so no
 *                half-space, mesh or height field
 * @param pose    where it starts; local_position and local_rotation of the shape do not count
 * @param path    three floats: how far it goes (m), together at most 1e7
 * @param filter  which shapes count; NULL for all
 * @param out     filled on LS_OK; its shape is null if nothing is met
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_shape_cast(LsWorld world,
                             const LsShapeDef *shape,
                             const LsPose *pose,
                             const float path[3],
                             const LsQueryFilter *filter,
                             LsRayHit *out);

/**
 * Every shape that a solid meets on a straight path, without turning, nearest first.
 *
 * @param world     the world; any value is safe
 * @param shape     filled by ls_shape_def_init and changed as wanted; as in ls_world_shape_cast
 * @param pose      where it starts
 * @param path      three floats: how far it goes (m), together at most 1e7
 * @param filter    which shapes count; NULL for all
 * @param out       room for capacity hits, filled on LS_OK, nearest first; may be NULL if capacity is 0
 * @param capacity  number that fit
 * @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_shape_cast_all(LsWorld world,
                                 const LsShapeDef *shape,
                                 const LsPose *pose,
                                 const float path[3],
                                 const LsQueryFilter *filter,
                                 LsRayHit *out,
                                 size_t capacity,
                                 size_t *count);

/**
 * Every shape that a solid overlaps or touches, in a fixed order.
 *
 * @param world     the world; any value is safe
 * @param shape     filled by ls_shape_def_init and changed as wanted; as in ls_world_shape_cast
 * @param pose      where it is; positions (m)
 * @param filter    which shapes count; NULL for all
 * @param out       room for capacity shapes, filled on LS_OK, in a fixed order; may be NULL if capacity is 0
 * @param capacity  number that fit
 * @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE, LS_ERROR_NOT_APPLICABLE, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_shape_overlaps_get(LsWorld world,
                                     const LsShapeDef *shape,
                                     const LsPose *pose,
                                     const LsQueryFilter *filter,
                                     LsShape *out,
                                     size_t capacity,
                                     size_t *count);

/**
 * Every shape whose world box meets a box, in a fixed order; cheaper than ls_world_shape_overlaps_get and less exact.
 *
 * @param world     the world; any value is safe
 * @param min       three doubles: the least corner (m)
 * @param max       three doubles: the greatest corner (m)
 * @param filter    which shapes count; NULL for all
 * @param out       room for capacity shapes, filled on LS_OK, in a fixed order; may be NULL if capacity is 0
 * @param capacity  number that fit
 * @param count     number of them, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_box_overlaps_get(LsWorld world,
                                   const double *min,
                                   const double *max,
                                   const LsQueryFilter *filter,
                                   LsShape *out,
                                   size_t capacity,
                                   size_t *count);

/**
 * The shape nearest to a point.
 *
 * @param world         the world; any value is safe
 * @param point         three doubles (m)
 * @param max_distance  how far to look (m), 0 to 1e7
 * @param filter        which shapes count; NULL for all
 * @param out           filled on LS_OK; its shape is null if there is none
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_nearest_point_get(LsWorld world,
                                    const double point[3],
                                    float max_distance,
                                    const LsQueryFilter *filter,
                                    LsNearestPoint *out);

/* Drawing --------------------------------------------------------------------------------------------------------- */

/**
 * Fills a drawing order with defaults: outlines and joints, and no callbacks.
 *
 * @param draw  filled on LS_OK
 * @param size  sizeof *draw as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_draw_init(LsDraw *draw, size_t size);

/**
 * Draws what a world holds now, layer by layer, through the callbacks of the drawing order. Nothing is changed or kept.
 *
 * @param world  the world; any value is safe
 * @param draw   filled by ls_draw_init and changed as wanted; read during the call
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_OUT_OF_RANGE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_draw(LsWorld world, const LsDraw *draw);

/* Snapshots ------------------------------------------------------------------------------------------------------- */

/**
 * Writes a whole world into a buffer: bodies, shapes, joints, contacts, sleep, and what the solver carries from step to step.
 *
 * About 160 bytes a body, 48 a pair of shapes near each other and 40 a contact point, beside joints and one copy of each
 * distinct geometry. Arrays of the last step and callbacks are not part of it.
 * @param world     the world; any value is safe
 * @param buffer    room for capacity bytes, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of bytes that fit
 * @param size      number of bytes of the snapshot, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_save(LsWorld world, void *buffer, size_t capacity, size_t *size);

/**
 * Makes a world what it was when the snapshot was written: every later step gives the same bits.
 *
 * Handles of what existed then are valid again; those of what came later are not. Into another world a snapshot can be restored
 * too: handles then have that world's number in them (ls_world_bodies_get lists them). Arrays of the last step end here;
 * callbacks, threads and what the host's words mean stay as they are.
 * @param world          the world; any value is safe
 * @param snapshot       as ls_world_save wrote it, by the same version of the library
 * @param snapshot_size  its number of bytes
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_SNAPSHOT
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_restore(LsWorld world, const void *snapshot, size_t snapshot_size);

/* Recordings ------------------------------------------------------------------------------------------------------ */

/**
 * Begins to record: the world as it is now, and from then on every call that changes it, with the hash of its state after each
 * step. A recording of this world that is under way ends.
 *
 * Calls that are refused are listed. What does not reach the state is not: reads, threads and job systems, callbacks.
 * @param world     the world; any value is safe
 * @param callback  takes the bytes, in order; not NULL
 * @param flags     0 or LS_RECORD_HASH_EVERY_CALL
 * @param user      handed back to the callback; must stay valid until the recording ends or the world is destroyed
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_ENUM, LS_ERROR_UNSUPPORTED (the callback refused)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_recording_start(LsWorld world, LsRecordCallback callback, uint32_t flags, void *user);

/**
 * As ls_world_recording_start, into a file: what was there before is gone.
 *
 * Each call is written when it is made, so that the file of a program that crashed holds all calls but the one that crashed.
 * @param world  the world; any value is safe
 * @param path   name of the file, UTF-8, ends with a zero
 * @param flags  0 or LS_RECORD_HASH_EVERY_CALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_INVALID_ENUM, LS_ERROR_UNSUPPORTED (the file took nothing),
 *         LS_ERROR_OTHER (the file cannot be made)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_recording_start_to_file(LsWorld world, const char *path, uint32_t flags);

/**
 * Ends the recording of a world.
 *
 * @param world  the world; any value is safe
 * @return LS_OK, a world error, LS_ERROR_NOT_APPLICABLE (it is not recorded), LS_ERROR_UNSUPPORTED (the file or callback has
 *         refused a part of the recording, which ended there)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_recording_stop(LsWorld world);

/**
 * Plays a recording in a world of its own, to its end or to the first call that comes out otherwise than recorded.
 *
 * A difference is no failure of this call: the report names it. The same version of the library, on any machine, gives none.
 * @param recording       the bytes, as they were written
 * @param recording_size  number of bytes
 * @param most_steps      after so many steps the replay stops; UINT64_MAX for all
 * @param out             the world as the replay left it, on LS_OK, for the host to look at, go on with and destroy; may be NULL
 * @param report          what was done, filled on LS_OK
 * @param size            sizeof *report as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_SNAPSHOT (the bytes are not a recording of this
 *         version, or a call in it makes no sense), LS_ERROR_CAPACITY_EXCEEDED
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_recording_replay(const void *recording,
                             size_t recording_size,
                             uint64_t most_steps,
                             LsWorld *out,
                             LsReplay *report,
                             size_t size);

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
 * Makes a body static, kinematic or dynamic, and wakes it and what it touches.
 *
 * A body that becomes static stops; one that becomes dynamic has the mass that it was made with or given. A joint none of whose bodies is
 * dynamic, as of a ragdoll that an animation moves, is idle: it holds nothing, bears nothing and tells its coordinates, until one is again.
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param kind   LS_BODY_ constant
 * @return LS_OK, a world error, a handle error, LS_ERROR_INVALID_ENUM, LS_ERROR_OUT_OF_RANGE (it would have no mass),
 *         LS_ERROR_NOT_APPLICABLE (a shape cannot be on a dynamic body)
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_body_kind_set(LsWorld world, LsBody body, int32_t kind);

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
 * stands still unless it is told again. A velocity or a pose that it is given before that step ends this: the last call counts.
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
 * Sets the velocity of a body's centre of mass (m/s). A kinematic body forgets where ls_body_move_to was to take it in the next step.
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
 * Sets the angular velocity of a body, world axes (rad/s). A kinematic body forgets where ls_body_move_to was to take it in the next step.
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
 * The step changes its velocity by force · step / mass. What touches nothing and has no joints is moved by the velocity at
 * the step's end, gravity included (symplectic Euler), and so is, as a whole, what touches or is jointed only among itself:
 * springs, orbits, magnets and buoyancy that are worked out of the poses before each step keep their energy, and a constant
 * thrust is half a step ahead of its parabola. On what touches or is jointed to something fixed the force is spread over the
 * step.
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
 * Rates at which velocities decay.
 *
 * @param world    the world; any value is safe
 * @param body     a body of that world; any value is safe
 * @param linear   rate for the linear velocity (1/s), filled on LS_OK
 * @param angular  rate for the angular velocity (1/s), filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_damping_get(LsWorld world, LsBody body, float *linear, float *angular);

/**
 * Sets the rates at which velocities decay. That is implicit: a rate k makes v / (1 + k h) of a velocity v in each substep of
 * length h (s), which is v exp(-k t) for small k h, and never turns a velocity around.
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
 * Factor on the world's gravity.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_gravity_scale_get(LsWorld world, LsBody body, float *out);

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
 * Degrees of freedom taken away.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    bit set of LS_LOCK_ constants, filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_locked_axes_get(LsWorld world, LsBody body, uint32_t *out);

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
 * Whether a body is swept through the step.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    1 if it is, else 0; filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_fast_get(LsWorld world, LsBody body, uint32_t *out);

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
 * Whether a body may fall asleep.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    1 if it may, else 0; filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_can_sleep_get(LsWorld world, LsBody body, uint32_t *out);

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
 * Whether a body is awake; static and kinematic ones always are, what is welded to static ones and may sleep never is.
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
 * Net force of all contacts on a body in the last substep (N): of those that there were then, also where what touched it has been
 * destroyed or moved since.
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
 * Whether a shape only tells what it overlaps; ls_shape_def_set changes it.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param out    1 if it does, else 0; filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_sensor_get(LsWorld world, LsShape shape, uint32_t *out);

/**
 * Sets the host's own word of a shape.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param word   any value
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_shape_user_word_set(LsWorld world, LsShape shape, uint64_t word);

/**
 * Surface of a shape.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_material_get(LsWorld world, LsShape shape, LsMaterial *out);

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
 * Which other shapes a shape collides with.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_filter_get(LsWorld world, LsShape shape, LsCollisionFilter *out);

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

/**
 * The definition that a shape has now. It may be changed and given to ls_shape_def_set or ls_shape_attach.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param out    filled on LS_OK; fields that the kind does not name have their defaults. Its arrays are owned by the shape and
 *               may be read until the shape is destroyed or given another definition. A compound has its part_count, and
 *               NULL for parts: see ls_shape_part_get
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_def_get(LsWorld world, LsShape shape, LsShapeDef *out, size_t size);

/**
 * One part of a compound shape.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param index  number of the part, from 0
 * @param out    filled on LS_OK with the part's geometry, local_position and local_rotation; the rest has its defaults. Its
 *               arrays are owned by the shape, as those of ls_shape_def_get
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_APPLICABLE (not a
 *         compound), LS_ERROR_INDEX_OUT_OF_RANGE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_shape_part_get(LsWorld world, LsShape shape, size_t index, LsShapeDef *out, size_t size);

/**
 * Gives a shape another definition: form, place, surface, density, filter and word. Its handle stays; a body whose mass comes
 * from its shapes is weighed again; what touched the shape wakes.
 *
 * @param world  the world; any value is safe
 * @param shape  a shape of that world; any value is safe
 * @param def    filled by ls_shape_def_init or ls_shape_def_get and changed as wanted; read during the call
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
 *         LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_UNIT, LS_ERROR_DEGENERATE,
 *         LS_ERROR_INDEX_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_shape_def_set(LsWorld world, LsShape shape, const LsShapeDef *def);

/* Joints ---------------------------------------------------------------------------------------------------------- */

/**
 * Creates a joint between two bodies, or a body and the world; it is idle while none of them is dynamic.
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
 * One axis of a joint at the end of the last step, numbered as in LsJointStop: axis 0 of a hinge, a prismatic or a distance joint; the
 * twist (0) and the swing (1) of a spherical joint; the translations along x, y and z (0 to 2) and the rotations about them (3 to 5)
 * of a generic joint.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param axis   number of the axis
 * @param out    filled on LS_OK
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_joint_axis_state_get(LsWorld world, LsJoint joint, uint32_t axis, LsJointAxisState *out, size_t size);

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
 * Sets the dry friction of a hinge, prismatic or spherical joint, and wakes its bodies: LsJointDef.friction, which
 * ls_joint_def_get tells.
 *
 * @param world     the world; any value is safe
 * @param joint     a joint of that world; any value is safe
 * @param friction  (N m; N of a prismatic joint), >= 0
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_friction_set(LsWorld world, LsJoint joint, float friction);

/**
 * Sets the dry friction of a generic joint's axes, and wakes its bodies: LsJointDef.axis_friction, which ls_joint_def_get tells.
 *
 * @param world     the world; any value is safe
 * @param joint     a joint of that world; any value is safe
 * @param friction  six floats: along x, y, z (N), then about them (N m), >= 0
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_axis_friction_set(LsWorld world, LsJoint joint, const float friction[6]);

/**
 * Sets the restitution of a joint's rigid stops, and wakes its bodies: LsJointDef.restitution, which ls_joint_def_get tells.
 *
 * @param world        the world; any value is safe
 * @param joint        a joint of that world; any value is safe
 * @param restitution  coefficient of restitution, 0 to 1: a limit that is met at v is left at this share of v
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_restitution_set(LsWorld world, LsJoint joint, float restitution);

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

/**
 * Says whether long-range constraints are derived from a joint, and wakes its bodies. Without it a chain ends there.
 *
 * @param world    the world; any value is safe
 * @param joint    a joint of that world; any value is safe
 * @param enabled  not 0: bounds lead past it, it may be in a plane of hinges, and, fixed, in a union; 0: none of these
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_long_range_set(LsWorld world, LsJoint joint, uint32_t enabled);

/**
 * Says how the articulation of a joint is solved, and wakes its bodies: LsJointDef.solver.
 *
 * @param world   the world; any value is safe
 * @param joint   a joint of that world; any value is safe
 * @param solver  LS_SOLVER_ constant
 * @return LS_OK, a world error, a handle error, LS_ERROR_INVALID_ENUM
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_solver_set(LsWorld world, LsJoint joint, int32_t solver);

/**
 * Sets where a joint is on its bodies and wakes them; the joint carries nothing over, as after a teleport.
 *
 * @param world    the world; any value is safe
 * @param joint    a joint of that world; any value is safe
 * @param frame_a  joint frame on body A, in its frame (in world coordinates if A is the world); positions (m)
 * @param frame_b  joint frame on body B, likewise
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE,
 *         LS_ERROR_NOT_UNIT
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_frames_set(LsWorld world, LsJoint joint, const LsPose *frame_a, const LsPose *frame_b);

/**
 * The host's own word of a joint.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_joint_user_word_get(LsWorld world, LsJoint joint, uint64_t *out);

/**
 * Sets the host's own word of a joint.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param word   any value
 * @return LS_OK, a world error, a handle error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_user_word_set(LsWorld world, LsJoint joint, uint64_t word);

/**
 * Switches the support analysis on or off; at the start it is off and costs nothing.
 *
 * While it is on, every step ends with it, and the other ls_support_ functions answer.
 * @param world  the world; any value is safe
 * @param on     0 for off, anything else for on
 * @return LS_OK, a world error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_support_enabled_set(LsWorld world, uint32_t on);

/**
 * Whether bodies are held up, or why not.
 *
 * @param world   the world; any value is safe
 * @param bodies  bodies of that world; any values are safe; may be NULL if count is 0
 * @param count   number of bodies
 * @param out     room for as many verdicts, filled on LS_OK; may be NULL if count is 0
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_get(LsWorld world, const LsBody *bodies, size_t count, LsSupport *out);

/**
 * Number of dynamic bodies that have support, by the changes told so far.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @return LS_OK, a world error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_count_get(LsWorld world, size_t *out);

/**
 * Dynamic bodies that gained or lost support in the last step. A loss is told at once, a gain when it has lasted for six steps.
 *
 * @param world     the world; any value is safe
 * @param out       room for capacity changes; may be NULL if capacity is 0
 * @param capacity  number of changes that fit
 * @param count     number of changes there are, written whenever it is not NULL and the world can be read
 * @return LS_OK, a world error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_changes_get(LsWorld world, LsSupportChange *out, size_t capacity, size_t *count);

/**
 * Corners of the hull of a body's supporting contacts, seen along gravity: in the plane through its centre of mass across gravity.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity points of three numbers (m); may be NULL if capacity is 0
 * @param capacity  number of points that fit
 * @param count     number of corners, written whenever it is not NULL and the body can be read
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_hull_get(LsWorld world, LsBody body, double (*out)[3], size_t capacity, size_t *count);

/**
 * Bodies that carry a body, through supporting contacts or joints.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity bodies; may be NULL if capacity is 0
 * @param capacity  number of bodies that fit
 * @param count     number of bodies there are, written whenever it is not NULL and the body can be read
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_carriers_get(LsWorld world, LsBody body, LsBody *out, size_t capacity, size_t *count);

/**
 * Bodies that a body carries through supporting contacts, or that hang on it by joints.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity bodies; may be NULL if capacity is 0
 * @param capacity  number of bodies that fit
 * @param count     number of bodies there are, written whenever it is not NULL and the body can be read
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_carried_get(LsWorld world, LsBody body, LsBody *out, size_t capacity, size_t *count);

/**
 * The way that a body's weight takes to the ground: the body itself, then always what carries most of the one before, to a body
 * that needs no support. Empty for a body without support; a joint to the world itself ends the way.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity bodies; may be NULL if capacity is 0
 * @param capacity  number of bodies that fit
 * @param count     number of bodies there are, written whenever it is not NULL and the body can be read
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_path_get(LsWorld world, LsBody body, LsBody *out, size_t capacity, size_t *count);

/**
 * Force with which everything that stands on a body presses it down, along gravity, in the last substep.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    force (N), filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_load_get(LsWorld world, LsBody body, float *out);

/**
 * Force with which one body presses another down through their contacts, along gravity, in the last substep.
 *
 * @param world  the world; any value is safe
 * @param upper  a body of that world; any value is safe
 * @param lower  a body of that world; any value is safe
 * @param out    force (N), filled on LS_OK
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_load_between_get(LsWorld world, LsBody upper, LsBody lower, float *out);

/**
 * Bodies that are supported now and would not be without some others. The world stays as it is.
 *
 * This asks the graph of contacts, joints and hulls; it is not a simulation. It knows what no longer reaches the ground or has its
 * centre of mass over nothing, but not what a fall would knock over, nor that what is left might slide.
 * @param world          the world; any value is safe
 * @param removed        bodies of that world; any values are safe; may be NULL if removed_count is 0
 * @param removed_count  number of them
 * @param out            room for capacity bodies; may be NULL if capacity is 0
 * @param capacity       number of bodies that fit
 * @param count          number of bodies there are, written whenever it is not NULL and the bodies can be read
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE (the analysis is off), LS_ERROR_NULL_ARGUMENT,
 *         LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_support_loss_predict(LsWorld world,
                                 const LsBody *removed,
                                 size_t removed_count,
                                 LsBody *out,
                                 size_t capacity,
                                 size_t *count);

/**
 * Fills a definition of long-range constraints with defaults.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_long_range_def_init(LsLongRangeDef *def, size_t size);

/**
 * Changes what a world derives from its joints, and wakes everything.
 *
 * @param world  the world; any value is safe
 * @param def    filled by ls_long_range_def_init and changed as wanted; read during the call
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_long_range_set(LsWorld world, const LsLongRangeDef *def);

/**
 * What a world derives from its joints.
 *
 * @param world  the world; any value is safe
 * @param out    filled on LS_OK
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_long_range_get(LsWorld world, LsLongRangeDef *out, size_t size);

/**
 * Asks for a soft bound between two joints, or changes it, and wakes their bodies. It ends with either joint.
 *
 * @param world    the world; any value is safe
 * @param joint_a  a joint of that world; any value is safe
 * @param joint_b  another one, connected to it by bodies and joints; any value is safe
 * @param bound    read during the call
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_soft_bound_set(LsWorld world, LsJoint joint_a, LsJoint joint_b, const LsSoftBound *bound);

/**
 * Takes a soft bound back and wakes the bodies of its joints; where there is none, nothing changes.
 *
 * @param world    the world; any value is safe
 * @param joint_a  a joint of that world; any value is safe
 * @param joint_b  another one; any value is safe
 * @return LS_OK, a world error, a handle error, LS_ERROR_NOT_APPLICABLE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_soft_bound_remove(LsWorld world, LsJoint joint_a, LsJoint joint_b);

/**
 * Every bound that was derived for the last step, with what it did.
 *
 * @param world     the world; any value is safe
 * @param out       room for `capacity` bounds, may be NULL if that is 0
 * @param capacity  how many fit
 * @param count     set to how many there are on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL (nothing is written to `out` then)
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_bounds_get(LsWorld world, LsBound *out, size_t capacity, size_t *count);

/**
 * The plane of every chain of hinges that was found for the last step.
 *
 * @param world     the world; any value is safe
 * @param out       room for `capacity` planes, may be NULL if that is 0
 * @param capacity  how many fit
 * @param count     set to how many there are on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL (nothing is written to `out` then)
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_planes_get(LsWorld world, LsPlane *out, size_t capacity, size_t *count);

/**
 * How far the chain between two joints is stretched, and what it bears. It leads along the shortest path past bodies that joints can
 * move and joints that hold two points together without give.
 *
 * @param world    the world; any value is safe
 * @param joint_a  a joint of that world; any value is safe
 * @param joint_b  another one, connected to it; any value is safe
 * @param out      filled on LS_OK
 * @param size     sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_APPLICABLE (the two are the
 *         same, or no chain connects them)
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_chain_state_get(LsWorld world, LsJoint joint_a, LsJoint joint_b, LsChainState *out, size_t size);

/**
 * The links of the chain between two joints, from the first joint to the second, as ls_chain_state_get finds it.
 *
 * @param world     the world; any value is safe
 * @param joint_a   a joint of that world; any value is safe
 * @param joint_b   another one, connected to it; any value is safe
 * @param out       room for `capacity` links, may be NULL if that is 0
 * @param capacity  how many fit
 * @param count     set to how many there are on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL (nothing is written to `out`
 *         then), LS_ERROR_NOT_APPLICABLE (the two are the same, or no chain connects them)
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_chain_links_get(LsWorld world,
                            LsJoint joint_a,
                            LsJoint joint_b,
                            LsChainLink *out,
                            size_t capacity,
                            size_t *count);

/**
 * The union that a dynamic body belongs to. Joints made or changed since the last step count from the next one on, and until then
 * their bodies belong to no union.
 *
 * @param world  the world; any value is safe
 * @param body   a body of that world; any value is safe
 * @param out    filled on LS_OK; with a null lead and no members where the body belongs to none
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_union_get(LsWorld world, LsBody body, LsUnion *out);

/**
 * Dynamic bodies of the union that a body belongs to, in order of their slots; none where it belongs to none.
 *
 * @param world     the world; any value is safe
 * @param body      a body of that world; any value is safe
 * @param out       room for capacity handles; may be NULL if capacity is 0
 * @param capacity  number of handles that fit
 * @param count     number of members there are, written whenever it is not NULL and the body can be read
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_body_union_members_get(LsWorld world, LsBody body, LsBody *out, size_t capacity, size_t *count);

/**
 * Every union of a world, by lead.
 *
 * @param world     the world; any value is safe
 * @param out       room for capacity unions; may be NULL if capacity is 0
 * @param capacity  number of unions that fit
 * @param count     number of unions there are, written whenever it is not NULL and the world can be read
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_unions_get(LsWorld world, LsUnion *out, size_t capacity, size_t *count);

/**
 * Sets the function that receives broken joints; at the start there is none.
 *
 * @param world     the world; any value is safe
 * @param callback  called by ls_world_step; NULL for none
 * @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
 * @return LS_OK, a world error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_break_callback_set(LsWorld world, LsBreakCallback callback, void *user);

/**
 * Sets the function that receives unions that fell into pieces; at the start there is none.
 *
 * @param world     the world; any value is safe
 * @param callback  called by ls_world_step; NULL for none
 * @param user      handed back to the callback; must stay valid until another callback is set or the world is destroyed
 * @return LS_OK, a world error
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_split_callback_set(LsWorld world, LsSplitCallback callback, void *user);

/**
 * Joints that broke in the last step, in the order in which they did.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_joint_breaks_get(LsWorld world, const LsJointBreak **out, size_t *count);

/**
 * Unions that fell into pieces in the last step, by their lowest member.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_splits_get(LsWorld world, const LsSplit **out, size_t *count);

/**
 * The pieces of all splits of the last step, split by split.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_pieces_get(LsWorld world, const LsPiece **out, size_t *count);

/**
 * The members of all pieces of the last step, piece by piece.
 *
 * @param world  the world; any value is safe
 * @param out    the array, owned by the world, on LS_OK; may be read by any thread until the next step of the world or its
 *               destruction, edits leave it as it is; do not follow it if the count is 0
 * @param count  number of elements
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_piece_bodies_get(LsWorld world, const LsBody **out, size_t *count);

/**
 * Has joints break in the next step, where a step breaks joints: what ls_world_joint_breaks_get lists on a server makes a client that was
 * in the same state before the step the same after it, bit for bit.
 *
 * The part of a handle that says which world it is of is not looked at. Joints that have been destroyed are passed over; lists
 * given before the same step add up.
 * @param world   the world; any value is safe
 * @param joints  count handles
 * @param count   number of handles; 0 is allowed
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_fractures_apply(LsWorld world, const LsJoint *joints, size_t count);

/**
 * Sets whether and how fast joints break.
 *
 * @param world     the world; any value is safe
 * @param settings  read during the call
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_fracture_settings_set(LsWorld world, const LsFractureSettings *settings);

/**
 * Sets what a joint bears before it breaks.
 *
 * @param world     the world; any value is safe
 * @param joint     a joint of that world; any value is safe
 * @param strength  read during the call
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_joint_strength_set(LsWorld world, LsJoint joint, const LsStrength *strength);

/**
 * What a joint bears at present, against what it can.
 *
 * @param world  the world; any value is safe
 * @param joint  a joint of that world; any value is safe
 * @param out    filled on LS_OK
 * @param size   sizeof *out as the host knows it
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_joint_stress_get(LsWorld world, LsJoint joint, LsJointStress *out, size_t size);

/**
 * How close many joints are to breaking.
 *
 * @param world   the world; any value is safe
 * @param joints  count handles
 * @param count   number of handles; 0 is allowed
 * @param out     room for count fractions of a limit, 1 breaks, filled on LS_OK in the order of the handles; one bad handle,
 *                and none is written
 * @return LS_OK, a world error, a handle error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_joint_shares_get(LsWorld world, const LsJoint *joints, size_t count, float *out);

/**
 * Joints that bear at least a share of a limit, those closest to breaking first.
 *
 * @param world     the world; any value is safe
 * @param least     fraction of a limit from which on they are listed, >= 0; 1 breaks
 * @param out       room for capacity handles, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of handles that fit
 * @param count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_NOT_FINITE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_BUFFER_TOO_SMALL
 * Threads: read. Callbacks: allowed.
 */
LsResult ls_world_joints_near_breaking_get(LsWorld world, float least, LsJoint *out, size_t capacity, size_t *count);

/**
 * Points spread evenly at random through a box or a convex hull, to cut it by; the same for the same seed on every machine.
 *
 * @param shape  a box or convex hull
 * @param count  number of points, 1 to 65536
 * @param seed   any value
 * @param out    room for 3 * count floats: x, y, z of each point, in the shape's frame (m); filled on LS_OK
 * @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_APPLICABLE,
 *         LS_ERROR_DEGENERATE, and what ls_shape_attach returns about a shape
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_cell_seeds_get(const LsShapeDef *shape, size_t count, uint64_t seed, float *out);

/**
 * Cuts a box or a convex hull into the Voronoi cells of seeds: a body with a convex hull for each cell, and a fixed joint at each
 * face that two cells share, its x axis the face's normal, its limits the face's area times the stresses of the material. The
 * same seeds give the same cells.
 *
 * @param world           the world; any value is safe
 * @param body            pose and velocity of the solid, and what else its cells have in common; its shapes and mass are not used
 * @param shape           the solid; density, material and filter are those of its cells; local_position and local_rotation are not used
 * @param seeds           3 * seed_count floats: x, y, z of each seed, in the frame of the solid (m); none may be there twice
 * @param seed_count      1 to 65536
 * @param material        what the joints bear
 * @param bodies          room for body_capacity handles, filled on LS_OK in the order of the seeds whose cells are not empty
 * @param body_capacity   number of handles that fit; seed_count always suffices
 * @param body_count      number of cells, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @param joints          room for joint_capacity handles, filled on LS_OK; may be NULL if joint_capacity is 0
 * @param joint_capacity  number of handles that fit
 * @param joint_count     number of joints, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE, LS_ERROR_NOT_FINITE,
 *         LS_ERROR_NOT_APPLICABLE, LS_ERROR_DEGENERATE, LS_ERROR_BUFFER_TOO_SMALL, and what ls_body_create and ls_joint_create
 *         return about definitions
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_world_cells_create(LsWorld world,
                               const LsBodyDef *body,
                               const LsShapeDef *shape,
                               const float *seeds,
                               size_t seed_count,
                               const LsBondMaterial *material,
                               LsBody *bodies,
                               size_t body_capacity,
                               size_t *body_count,
                               LsJoint *joints,
                               size_t joint_capacity,
                               size_t *joint_count);

/* Streams --------------------------------------------------------------------------------------------------------- */

/**
 * Fills a stream definition with defaults.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_stream_def_init(LsStreamDef *def, size_t size);

/**
 * Begins to publish a world to other processes of this user, through shared memory; docs/reference/stream-bytes.md has the bytes.
 *
 * From now on each ls_world_step ends with a publication, which never waits and never fails: what cannot be placed is counted.
 * Leftovers of publishers that died are removed here. A world may have several streams.
 * @param world  the world; any value is safe
 * @param def    filled by ls_stream_def_init and changed as wanted; read during the call
 * @param out    the stream, on LS_OK; it ends with ls_stream_close, or with its world
 * @return LS_OK, LS_ERROR_UNSUPPORTED, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE,
 *         LS_ERROR_STREAM_SYSTEM
 * Threads: edit. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_stream_open(LsWorld world, const LsStreamDef *def, LsStream *out);

/**
 * Ends a stream.
 *
 * @param stream  the stream; any value is safe
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE, a world error
 * Threads: edit of its world. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_stream_close(LsStream stream);

/**
 * Lets readers in that have come since the last step, and gives them what they are to have; for a host that is not stepping its
 * world now. A step does it too.
 *
 * @param stream  the stream; any value is safe
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE, a world error
 * Threads: edit of its world. Callbacks: LS_ERROR_WORLD_LOCKED.
 */
LsResult ls_stream_serve(LsStream stream);

/**
 * What a stream has done so far.
 *
 * @param stream  the stream; any value is safe
 * @param out     filled on LS_OK
 * @param size    sizeof *out as the host knows it
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE, a world error,
 *         LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: read of its world. Callbacks: allowed.
 */
LsResult ls_stream_stats_get(LsStream stream, LsStreamStats *out, size_t size);

/**
 * Streams that are published now by processes of this user.
 *
 * @param domain    see LsStreamDef; may be NULL
 * @param out       room for capacity sources, filled on LS_OK; may be NULL if capacity is 0
 * @param capacity  number of sources that fit
 * @param count     number of streams, on LS_OK and LS_ERROR_BUFFER_TOO_SMALL
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_OUT_OF_RANGE, LS_ERROR_BUFFER_TOO_SMALL,
 *         LS_ERROR_STREAM_SYSTEM
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_stream_sources_get(const char *domain, LsStreamSource *out, size_t capacity, size_t *count);

/**
 * Fills a reader definition with defaults.
 *
 * @param def   filled on LS_OK
 * @param size  sizeof *def as the host knows it
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_stream_reader_def_init(LsStreamReaderDef *def, size_t size);

/**
 * Makes a reader of a stream, or of a recording. A stream need not be there yet, may end, and may begin anew: the reader finds it.
 *
 * What comes from a publisher is checked and never believed: no bytes of it make the reader fail in another way than by an error.
 * @param def  filled by ls_stream_reader_def_init and changed as wanted; read during the call
 * @param out  the reader, on LS_OK; the host ends it with ls_stream_reader_close
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_OUT_OF_RANGE,
 *         LS_ERROR_STREAM_SYSTEM, LS_ERROR_STREAM_INCOMPATIBLE, LS_ERROR_STREAM_CORRUPT
 * Threads: any thread at any time. Callbacks: allowed.
 */
LsResult ls_stream_reader_open(const LsStreamReaderDef *def, LsStreamReader *out);

/**
 * Ends a reader; its arrays end here. A file that it records is finished.
 *
 * @param reader  the reader; any value is safe
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_STREAM_SYSTEM
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_close(LsStreamReader reader);

/**
 * Takes in all that has come, and says what that was. Of a recording it takes the next frame.
 *
 * @param reader   the reader; any value is safe
 * @param timeout  how long to wait for a frame (s), 0 to 3600; 0 only looks. Who waits costs the publisher nothing.
 * @param out      filled on LS_OK
 * @param size     sizeof *out as the host knows it
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY (another thread uses the reader), LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE,
 *         LS_ERROR_OUT_OF_RANGE, LS_ERROR_STREAM_SYSTEM, LS_ERROR_STREAM_INCOMPATIBLE (a stream of another version),
 *         LS_ERROR_STREAM_CORRUPT (a message made no sense and was left out; the next call goes on)
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_poll(LsStreamReader reader, float timeout, LsStreamPoll *out, size_t size);

/**
 * Takes in the next frame, not the newest: for who wants each of them.
 *
 * @param reader  the reader; any value is safe
 * @param out     filled on LS_OK
 * @param size    sizeof *out as the host knows it
 * @return as ls_stream_reader_poll, LS_ERROR_NULL_ARGUMENT and LS_ERROR_STRUCT_SIZE among them
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_next(LsStreamReader reader, LsStreamPoll *out, size_t size);

/**
 * Goes to the frame of a step of a recording, or the last one before it.
 *
 * @param reader  the reader of a recording; any value is safe
 * @param step    number of the step
 * @param out     filled on LS_OK
 * @param size    sizeof *out as the host knows it
 * @return as ls_stream_reader_poll, LS_ERROR_NULL_ARGUMENT and LS_ERROR_STRUCT_SIZE among them; LS_ERROR_OUT_OF_RANGE if the
 *         reader reads a live stream
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_seek(LsStreamReader reader, uint64_t step, LsStreamPoll *out, size_t size);

/**
 * Settings of the world that the stream is of.
 *
 * @param reader  the reader; any value is safe
 * @param out     filled on LS_OK; all zero before they have been told
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_world_get(LsStreamReader reader, LsStreamWorld *out);

/**
 * Bodies as the last frame left them, by handle.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_bodies_get(LsStreamReader reader, const LsStreamBody **out, size_t *count);

/**
 * Shapes, by handle and part.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_shapes_get(LsStreamReader reader, const LsStreamShape **out, size_t *count);

/**
 * Joints, by handle.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_joints_get(LsStreamReader reader, const LsStreamJoint **out, size_t *count);

/**
 * Contacts of the last frame; none unless the stream has LS_STREAM_LAYER_CONTACTS.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_contacts_get(LsStreamReader reader, const LsStreamContact **out, size_t *count);

/**
 * What joints carry in the last frame; none unless the stream has LS_STREAM_LAYER_JOINT_LOADS.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_joint_loads_get(LsStreamReader reader, const LsStreamJointLoad **out, size_t *count);

/**
 * Long-range bounds of the last frame; none unless the stream has LS_STREAM_LAYER_BOUNDS.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_bounds_get(LsStreamReader reader, const LsStreamBound **out, size_t *count);

/**
 * Planes of hinge chains in the last frame; none unless the stream has LS_STREAM_LAYER_PLANES.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_planes_get(LsStreamReader reader, const LsStreamPlane **out, size_t *count);

/**
 * What happened, as far as the last call of ls_stream_reader_poll, _next or _seek brought it: the oldest first.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_events_get(LsStreamReader reader, const LsStreamEvent **out, size_t *count);

/**
 * Joints that broke since the last call of ls_stream_reader_poll, _next or _seek, the oldest first.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_breaks_get(LsStreamReader reader, const LsStreamBreak **out, size_t *count);

/**
 * Pieces of unions that fell apart since the last call of ls_stream_reader_poll, _next or _seek, the oldest first.
 *
 * @param reader  the reader; any value is safe
 * @param out     the array, owned by the reader, on LS_OK; may be read until the next call of ls_stream_reader_poll, _next, _seek
 *                or _close for this reader; do not follow it if the count is 0
 * @param count   number of elements
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_pieces_get(LsStreamReader reader, const LsStreamPiece **out, size_t *count);

/**
 * Triangles of a part of a shape that a few numbers do not describe: a hull, a mesh, a height field.
 *
 * @param reader          the reader; any value is safe
 * @param shape           LsStreamShape.shape
 * @param part            LsStreamShape.part
 * @param vertices        three floats each, in the part's frame (m), owned by the reader as its other arrays are
 * @param vertex_count    number of vertices; 0 if they have not come yet, or the part has none
 * @param triangles       three numbers of vertices each, counter-clockwise seen from outside, each less than vertex_count
 * @param triangle_count  number of triangles
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_mesh_get(LsStreamReader reader,
                                   uint64_t shape,
                                   uint32_t part,
                                   const float (**vertices)[3],
                                   size_t *vertex_count,
                                   const uint32_t (**triangles)[3],
                                   size_t *triangle_count);

/**
 * Hash of what the reader knows: the step, and handles, poses, velocities and flags of all bodies, and the joints. The same frame
 * of a recording has the same.
 *
 * @param reader  the reader; any value is safe
 * @param out     filled on LS_OK
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_hash_get(LsStreamReader reader, uint64_t *out);

/**
 * Records from now on all that the reader takes in.
 *
 * @param reader  the reader of a live stream; any value is safe
 * @param file    path of the file, replaced if it is there; NULL finishes the file under way
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_OUT_OF_RANGE, LS_ERROR_STREAM_SYSTEM; not LS_ERROR_NULL_ARGUMENT
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_record(LsStreamReader reader, const char *file);

/**
 * What is known of a recording as a whole.
 *
 * @param reader  the reader of a recording; any value is safe
 * @param out     filled on LS_OK
 * @param size    sizeof *out as the host knows it
 * @return LS_OK, LS_ERROR_UNSUPPORTED, LS_ERROR_NULL_HANDLE, LS_ERROR_INVALID_HANDLE, LS_ERROR_STALE_HANDLE,
 *         LS_ERROR_WORLD_BUSY, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_NOT_APPLICABLE (a live stream)
 * Threads: one thread at a time for each reader. Callbacks: allowed.
 */
LsResult ls_stream_reader_recording_get(LsStreamReader reader, LsStreamRecording *out, size_t size);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* LONGSPAN_H */

/* Names that functions had before version 0.1.0, for hosts that use them. Define LONGSPAN_NO_OLD_NAMES to leave them out. */
#ifndef LONGSPAN_NO_OLD_NAMES
#define ls_world_moved ls_world_moved_bodies_get
#define ls_world_articulations ls_world_articulations_get
#define ls_world_contact_began ls_world_contacts_begun_get
#define ls_world_contact_ended ls_world_contacts_ended_get
#define ls_world_overloaded ls_world_overloaded_joints_get
#define ls_world_quarantined ls_world_quarantined_bodies_get
#define ls_world_hits ls_world_hits_get
#define ls_world_joint_stops ls_world_joint_stops_get
#define ls_world_sensor_began ls_world_sensor_overlaps_begun_get
#define ls_world_sensor_ended ls_world_sensor_overlaps_ended_get
#define ls_world_sensed ls_world_sensor_overlaps_get
#define ls_world_shape_distance ls_world_shape_distance_get
#define ls_world_nearest_shape ls_world_nearest_shape_get
#define ls_world_nearest_point ls_world_nearest_point_get
#define ls_world_cast_ray ls_world_ray_cast
#define ls_world_cast_ray_all ls_world_ray_cast_all
#define ls_world_cast_rays ls_world_rays_cast
#define ls_world_cast_shape ls_world_shape_cast
#define ls_world_cast_shape_all ls_world_shape_cast_all
#define ls_world_overlap_shape ls_world_shape_overlaps_get
#define ls_world_overlap_box ls_world_box_overlaps_get
#define ls_world_record_start ls_world_recording_start
#define ls_world_record_to_file ls_world_recording_start_to_file
#define ls_world_record_stop ls_world_recording_stop
#define ls_world_unions ls_world_unions_get
#define ls_world_broken ls_world_joint_breaks_get
#define ls_world_splits ls_world_splits_get
#define ls_world_pieces ls_world_pieces_get
#define ls_world_piece_bodies ls_world_piece_bodies_get
#define ls_world_apply_fractures ls_world_fractures_apply
#define ls_world_joints_near_breaking ls_world_joints_near_breaking_get
#define ls_body_add_force ls_body_force_add
#define ls_body_add_force_at ls_body_force_add_at
#define ls_body_add_torque ls_body_torque_add
#define ls_body_add_impulse ls_body_impulse_add
#define ls_body_add_impulse_at ls_body_impulse_add_at
#define ls_body_add_angular_impulse ls_body_angular_impulse_add
#define ls_body_put_to_sleep ls_body_sleep
#define ls_body_union ls_body_union_get
#define ls_body_union_members ls_body_union_members_get
#define ls_support_enable ls_support_enabled_set
#define ls_support_of ls_support_get
#define ls_support_count ls_support_count_get
#define ls_support_changes ls_support_changes_get
#define ls_support_hull ls_support_hull_get
#define ls_support_from ls_support_carriers_get
#define ls_support_to ls_support_carried_get
#define ls_support_path ls_support_path_get
#define ls_support_load ls_support_load_get
#define ls_support_load_between ls_support_load_between_get
#define ls_support_lost_without ls_support_loss_predict
#define ls_cells_seeds ls_cell_seeds_get
#define ls_stream_reader_world ls_stream_reader_world_get
#define ls_stream_reader_bodies ls_stream_reader_bodies_get
#define ls_stream_reader_shapes ls_stream_reader_shapes_get
#define ls_stream_reader_joints ls_stream_reader_joints_get
#define ls_stream_reader_contacts ls_stream_reader_contacts_get
#define ls_stream_reader_joint_loads ls_stream_reader_joint_loads_get
#define ls_stream_reader_bounds ls_stream_reader_bounds_get
#define ls_stream_reader_planes ls_stream_reader_planes_get
#define ls_stream_reader_events ls_stream_reader_events_get
#define ls_stream_reader_breaks ls_stream_reader_breaks_get
#define ls_stream_reader_pieces ls_stream_reader_pieces_get
#define ls_stream_reader_mesh ls_stream_reader_mesh_get
#define ls_stream_reader_hash ls_stream_reader_hash_get
#define ls_version ls_version_get
#define ls_result_name ls_result_name_get
#define ls_last_error_message ls_last_error_message_get
/** Old name of LS_STRENGTH_TENSION. */
#define LS_LIMIT_TENSION LS_STRENGTH_TENSION
/** Old name of LS_STRENGTH_COMPRESSION. */
#define LS_LIMIT_COMPRESSION LS_STRENGTH_COMPRESSION
/** Old name of LS_STRENGTH_SHEAR. */
#define LS_LIMIT_SHEAR LS_STRENGTH_SHEAR
/** Old name of LS_STRENGTH_BENDING. */
#define LS_LIMIT_BENDING LS_STRENGTH_BENDING
/** Old name of LS_STRENGTH_TORSION. */
#define LS_LIMIT_TORSION LS_STRENGTH_TORSION
#endif
