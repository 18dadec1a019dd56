// What the benchmark needs of Jolt, as C: its own C bindings have no constraints. Lengths in m, masses in kg, angles in rad.
// Quaternions are x, y, z, w. Handles are indices in order of creation; an index that was removed must not be used again.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct JoltWorld JoltWorld;
typedef struct JoltShape JoltShape;

typedef struct JoltVec3 {
	float x, y, z;
} JoltVec3;

typedef struct JoltQuat {
	float x, y, z, w;
} JoltQuat;

typedef struct JoltFrame {
	JoltVec3 position;
	JoltQuat rotation;
} JoltFrame;

typedef struct JoltWorldDef {
	JoltVec3 gravity;
	float restitution_threshold;
	uint32_t collision_steps;
	uint32_t threads;
	bool allow_sleeping;
} JoltWorldDef;

// Mass, centre of mass in the body's frame, and inertia tensor about it in the body's axes, column by column.
typedef struct JoltMass {
	float mass;
	JoltVec3 center;
	float inertia[9];
} JoltMass;

typedef enum JoltMotion { JOLT_STATIC = 0, JOLT_KINEMATIC = 1, JOLT_DYNAMIC = 2 } JoltMotion;

typedef struct JoltBodyDef {
	JoltFrame frame;
	JoltVec3 linear_velocity; // of the centre of mass
	JoltVec3 angular_velocity;
	JoltMass mass; // of a dynamic body
	float friction;
	float restitution;
	float linear_damping;
	float angular_damping;
	float gravity_factor;
	uint32_t motion; // JoltMotion
	uint32_t member_of;
	uint32_t collides_with;
	uint8_t allowed_axes; // translation x, y, z, rotation x, y, z from the lowest bit
	bool continuous;
	bool allow_sleeping;
} JoltBodyDef;

typedef enum JoltJointKind {
	JOLT_FIXED = 0,
	JOLT_HINGE = 1,     // about x
	JOLT_POINT = 2,
	JOLT_DISTANCE = 3,
	JOLT_SLIDER = 4,    // along x
	JOLT_CONE = 5       // a point whose x axes stay within `max` of each other
} JoltJointKind;

#define JOLT_GROUND UINT32_MAX // in place of a body: the world itself

typedef struct JoltJointDef {
	uint32_t kind; // JoltJointKind
	uint32_t a, b;
	JoltFrame frame_a, frame_b; // in the frames of the bodies
	bool limited;
	float min, max;
	bool driven; // a hinge at `motor_speed` (rad/s) with at most `motor_torque` (N·m)
	float motor_speed, motor_torque;
	bool collide_connected;
} JoltJointDef;

JoltWorld *jolt_world_create(const JoltWorldDef *def);
void jolt_world_destroy(JoltWorld *world);
// Returns 0, or Jolt's error bits: some contacts were dropped because a buffer was full.
uint32_t jolt_world_step(JoltWorld *world, float dt);
// Wakes every body.
void jolt_world_set_gravity(JoltWorld *world, JoltVec3 gravity);

// A shape is null if Jolt refuses to build it. It is freed with `jolt_shape_release`, also after bodies or compounds use it.
JoltShape *jolt_shape_ball(float radius);
JoltShape *jolt_shape_box(JoltVec3 half_extents);
JoltShape *jolt_shape_capsule(float half_height, float radius);
JoltShape *jolt_shape_cylinder(float half_height, float radius);
JoltShape *jolt_shape_hull(const JoltVec3 *points, size_t count);
// `shape` moved and turned.
JoltShape *jolt_shape_placed(const JoltShape *shape, JoltFrame frame);
// Two or more shapes as one; a null entry makes the result null.
JoltShape *jolt_shape_compound(const JoltShape *const *shapes, size_t count);
void jolt_shape_release(JoltShape *shape);

uint32_t jolt_body_create(JoltWorld *world, const JoltShape *shape, const JoltBodyDef *def);
// Takes its joints with it.
void jolt_body_remove(JoltWorld *world, uint32_t body);
JoltFrame jolt_body_frame(const JoltWorld *world, uint32_t body);
JoltVec3 jolt_body_linear_velocity(const JoltWorld *world, uint32_t body);
JoltVec3 jolt_body_angular_velocity(const JoltWorld *world, uint32_t body);
void jolt_body_set_linear_velocity(JoltWorld *world, uint32_t body, JoltVec3 velocity);
void jolt_body_add_impulse(JoltWorld *world, uint32_t body, JoltVec3 impulse);
bool jolt_body_is_active(const JoltWorld *world, uint32_t body);
// What a dynamic body is solved with, from the inverses that Jolt keeps.
JoltMass jolt_body_mass(const JoltWorld *world, uint32_t body);

uint32_t jolt_joint_create(JoltWorld *world, const JoltJointDef *def);
// Force on body B in the last collision step (N); false for kinds whose impulses Jolt does not show, and removed joints.
bool jolt_joint_force(const JoltWorld *world, uint32_t joint, JoltVec3 *force);

#ifdef __cplusplus
}
#endif
