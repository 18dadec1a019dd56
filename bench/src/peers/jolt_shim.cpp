#include "jolt_shim.h"

// Jolt wants this one before all its others.
#include <Jolt/Jolt.h>

#include <Jolt/Core/Factory.h>
#include <Jolt/Core/JobSystemSingleThreaded.h>
#include <Jolt/Core/JobSystemThreadPool.h>
#include <Jolt/Core/TempAllocator.h>
#include <Jolt/Physics/Body/BodyCreationSettings.h>
#include <Jolt/Physics/Collision/GroupFilter.h>
#include <Jolt/Physics/Collision/Shape/BoxShape.h>
#include <Jolt/Physics/Collision/Shape/CapsuleShape.h>
#include <Jolt/Physics/Collision/Shape/ConvexHullShape.h>
#include <Jolt/Physics/Collision/Shape/CylinderShape.h>
#include <Jolt/Physics/Collision/Shape/OffsetCenterOfMassShape.h>
#include <Jolt/Physics/Collision/Shape/RotatedTranslatedShape.h>
#include <Jolt/Physics/Collision/Shape/SphereShape.h>
#include <Jolt/Physics/Collision/Shape/StaticCompoundShape.h>
#include <Jolt/Physics/Constraints/DistanceConstraint.h>
#include <Jolt/Physics/Constraints/FixedConstraint.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/Constraints/SliderConstraint.h>
#include <Jolt/Physics/Constraints/SwingTwistConstraint.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

#include <algorithm>
#include <cfloat>
#include <memory>
#include <mutex>
#include <vector>

JPH_SUPPRESS_WARNINGS

using namespace JPH;

namespace {

constexpr uint cMaxBodies = 65536;
constexpr uint cMaxBodyPairs = 65536;
constexpr uint cMaxContactConstraints = 65536;
// Reserved, not touched: a step takes from it what its contacts need.
constexpr uint cTempBytes = 256 * 1024 * 1024;

constexpr BroadPhaseLayer cStill(0);
constexpr BroadPhaseLayer cMoving(1);

Vec3 ToJolt(JoltVec3 inV) { return Vec3(inV.x, inV.y, inV.z); }
Quat ToJolt(JoltQuat inQ) { return Quat(inQ.x, inQ.y, inQ.z, inQ.w); }
JoltVec3 FromJolt(Vec3Arg inV) { return { inV.GetX(), inV.GetY(), inV.GetZ() }; }
JoltQuat FromJolt(QuatArg inQ) { return { inQ.GetX(), inQ.GetY(), inQ.GetZ(), inQ.GetW() }; }

// Jolt creates the jobs of all collision steps of an update in advance, in an array of fixed size that it runs past the end of.
// This many collision steps stay inside.
uint MaxCollisionSteps(uint inThreads) { return uint(cMaxPhysicsJobs) / (16 + 12 * inThreads); }

void StartJolt()
{
	static std::once_flag started;
	std::call_once(started, [] {
		RegisterDefaultAllocator();
		Factory::sInstance = new Factory();
		RegisterTypes();
	});
}

// One object layer per combination of motion and collision filter that a scene uses.
struct Layer {
	bool moving;
	uint32_t member_of;
	uint32_t collides_with;

	bool operator==(const Layer &inOther) const
	{
		return moving == inOther.moving && member_of == inOther.member_of && collides_with == inOther.collides_with;
	}
};

class Layers final : public BroadPhaseLayerInterface, public ObjectVsBroadPhaseLayerFilter, public ObjectLayerPairFilter {
public:
	ObjectLayer Of(const Layer &inLayer)
	{
		auto found = std::find(mLayers.begin(), mLayers.end(), inLayer);
		if (found == mLayers.end())
			found = mLayers.insert(found, inLayer);
		return ObjectLayer(found - mLayers.begin());
	}

	uint GetNumBroadPhaseLayers() const override { return 2; }

	BroadPhaseLayer GetBroadPhaseLayer(ObjectLayer inLayer) const override { return mLayers[inLayer].moving? cMoving : cStill; }

	bool ShouldCollide(ObjectLayer inLayer, BroadPhaseLayer inOther) const override
	{
		return mLayers[inLayer].moving || inOther == cMoving;
	}

	bool ShouldCollide(ObjectLayer inLayer1, ObjectLayer inLayer2) const override
	{
		const Layer &a = mLayers[inLayer1], &b = mLayers[inLayer2];
		return (a.moving || b.moving) && (a.member_of & b.collides_with) != 0 && (b.member_of & a.collides_with) != 0;
	}

private:
	std::vector<Layer> mLayers;
};

// Keeps jointed neighbours from colliding. Jolt's own table takes space for every pair of a fixed number of bodies.
// Only bodies with such a joint carry it; their subgroup is their index.
class NeighbourFilter final : public GroupFilter {
public:
	JPH_DECLARE_SERIALIZABLE_VIRTUAL(JPH_NO_EXPORT, NeighbourFilter)

	void Separate(uint32 inBody1, uint32 inBody2)
	{
		mNeighbours.resize(std::max<size_t>(mNeighbours.size(), std::max(inBody1, inBody2) + 1));
		mNeighbours[inBody1].push_back(inBody2);
		mNeighbours[inBody2].push_back(inBody1);
	}

	bool CanCollide(const CollisionGroup &inGroup1, const CollisionGroup &inGroup2) const override
	{
		if (inGroup2.GetGroupFilter() != this)
			return true;
		const std::vector<uint32> &neighbours = mNeighbours[inGroup1.GetSubGroupID()];
		return std::find(neighbours.begin(), neighbours.end(), inGroup2.GetSubGroupID()) == neighbours.end();
	}

private:
	std::vector<std::vector<uint32>> mNeighbours;
};

JPH_IMPLEMENT_SERIALIZABLE_VIRTUAL(NeighbourFilter)
{
	JPH_ADD_BASE_CLASS(NeighbourFilter, GroupFilter)
}

JoltShape *Owned(const Shape *inShape)
{
	inShape->AddRef();
	return reinterpret_cast<JoltShape *>(const_cast<Shape *>(inShape));
}

const Shape *Borrowed(const JoltShape *inShape) { return reinterpret_cast<const Shape *>(inShape); }

JoltShape *OwnedIfValid(const ShapeSettings::ShapeResult &inResult) { return inResult.IsValid()? Owned(inResult.Get()) : nullptr; }

// Jolt rounds edges by this much: its default, but never so much that a small shape loses its faces.
float ConvexRadius(float inLeastHalfExtent) { return std::min(cDefaultConvexRadius, 0.5f * inLeastHalfExtent); }

// Hands over both frames' x and y axes, by which every kind of Jolt's constraints describes a frame.
template <class Settings>
void SetAxes(Settings &ioSettings, const JoltJointDef &inDef, Vec3 Settings::*inAxis1, Vec3 Settings::*inNormal1,
	Vec3 Settings::*inAxis2, Vec3 Settings::*inNormal2)
{
	Quat a = ToJolt(inDef.frame_a.rotation), b = ToJolt(inDef.frame_b.rotation);
	ioSettings.*inAxis1 = a.RotateAxisX();
	ioSettings.*inNormal1 = a.RotateAxisY();
	ioSettings.*inAxis2 = b.RotateAxisX();
	ioSettings.*inNormal2 = b.RotateAxisY();
}

// The joint point of a frame, relative to the centre of mass, as Jolt wants it.
Vec3 Anchor(const Body &inBody, const JoltFrame &inFrame)
{
	Vec3 center = &inBody == &Body::sFixedToWorld? Vec3::sZero() : inBody.GetShape()->GetCenterOfMass();
	return ToJolt(inFrame.position) - center;
}

TwoBodyConstraint *CreateConstraint(const JoltJointDef &inDef, Body &inA, Body &inB)
{
	Vec3 point_a = Anchor(inA, inDef.frame_a), point_b = Anchor(inB, inDef.frame_b);
	auto create = [&](auto &ioSettings) {
		ioSettings.mSpace = EConstraintSpace::LocalToBodyCOM;
		ioSettings.mPoint1 = RVec3(point_a);
		ioSettings.mPoint2 = RVec3(point_b);
		return ioSettings.Create(inA, inB);
	};
	switch (inDef.kind)
	{
	case JOLT_FIXED:
		{
			FixedConstraintSettings settings;
			using S = FixedConstraintSettings;
			SetAxes(settings, inDef, &S::mAxisX1, &S::mAxisY1, &S::mAxisX2, &S::mAxisY2);
			return create(settings);
		}
	case JOLT_HINGE:
		{
			HingeConstraintSettings settings;
			using S = HingeConstraintSettings;
			SetAxes(settings, inDef, &S::mHingeAxis1, &S::mNormalAxis1, &S::mHingeAxis2, &S::mNormalAxis2);
			if (inDef.limited)
			{
				settings.mLimitsMin = inDef.min;
				settings.mLimitsMax = inDef.max;
			}
			settings.mMotorSettings.SetTorqueLimit(inDef.motor_torque);
			TwoBodyConstraint *hinge = create(settings);
			if (inDef.driven)
			{
				static_cast<HingeConstraint *>(hinge)->SetTargetAngularVelocity(inDef.motor_speed);
				static_cast<HingeConstraint *>(hinge)->SetMotorState(EMotorState::Velocity);
			}
			return hinge;
		}
	case JOLT_CONE:
		{
			SwingTwistConstraintSettings settings;
			using S = SwingTwistConstraintSettings;
			SetAxes(settings, inDef, &S::mTwistAxis1, &S::mPlaneAxis1, &S::mTwistAxis2, &S::mPlaneAxis2);
			settings.mSpace = EConstraintSpace::LocalToBodyCOM;
			settings.mPosition1 = RVec3(point_a);
			settings.mPosition2 = RVec3(point_b);
			settings.mNormalHalfConeAngle = settings.mPlaneHalfConeAngle = inDef.max;
			settings.mTwistMinAngle = -JPH_PI;
			settings.mTwistMaxAngle = JPH_PI;
			return settings.Create(inA, inB);
		}
	case JOLT_DISTANCE:
		{
			DistanceConstraintSettings settings;
			settings.mMinDistance = inDef.min;
			settings.mMaxDistance = inDef.max;
			return create(settings);
		}
	case JOLT_SLIDER:
		{
			SliderConstraintSettings settings;
			using S = SliderConstraintSettings;
			SetAxes(settings, inDef, &S::mSliderAxis1, &S::mNormalAxis1, &S::mSliderAxis2, &S::mNormalAxis2);
			if (inDef.limited)
			{
				settings.mLimitsMin = inDef.min;
				settings.mLimitsMax = inDef.max;
			}
			return create(settings);
		}
	default:
		{
			PointConstraintSettings settings;
			return create(settings);
		}
	}
}

} // namespace

struct JoltWorld {
	// Before the system, which keeps references to them.
	Layers layers;
	Ref<NeighbourFilter> neighbours = new NeighbourFilter;
	TempAllocatorImpl temp_allocator { cTempBytes };
	std::unique_ptr<JobSystem> jobs;
	PhysicsSystem system;
	uint32_t collision_steps = 1;
	// Of one update; more are done in several.
	uint32_t max_collision_steps = 1;
	// Length of the last collision step (s); zero before the first.
	float collision_dt = 0.0f;
	std::vector<Body *> bodies;
	std::vector<Ref<TwoBodyConstraint>> joints;

	Body &BodyOf(uint32_t inBody) { return inBody == JOLT_GROUND? Body::sFixedToWorld : *bodies[inBody]; }

	void Separate(uint32_t inBody1, uint32_t inBody2)
	{
		neighbours->Separate(inBody1, inBody2);
		for (uint32_t body : { inBody1, inBody2 })
			bodies[body]->SetCollisionGroup(CollisionGroup(neighbours, 0, body));
	}
};

JoltWorld *jolt_world_create(const JoltWorldDef *def)
{
	StartJolt();
	JoltWorld *world = new JoltWorld;
	if (def->threads > 1)
		world->jobs = std::make_unique<JobSystemThreadPool>(cMaxPhysicsJobs, cMaxPhysicsBarriers, int(def->threads) - 1);
	else
		world->jobs = std::make_unique<JobSystemSingleThreaded>(cMaxPhysicsJobs);
	world->system.Init(cMaxBodies, 0, cMaxBodyPairs, cMaxContactConstraints, world->layers, world->layers, world->layers);
	world->system.SetGravity(ToJolt(def->gravity));
	PhysicsSettings settings = world->system.GetPhysicsSettings();
	settings.mMinVelocityForRestitution = def->restitution_threshold;
	settings.mAllowSleeping = def->allow_sleeping;
	world->system.SetPhysicsSettings(settings);
	world->collision_steps = def->collision_steps;
	world->max_collision_steps = MaxCollisionSteps(def->threads);
	return world;
}

void jolt_world_destroy(JoltWorld *world)
{
	for (uint32_t body = 0; body < world->bodies.size(); ++body)
		if (world->bodies[body] != nullptr)
			jolt_body_remove(world, body);
	delete world;
}

uint32_t jolt_world_step(JoltWorld *world, float dt)
{
	// Jolt's advice after adding many bodies one by one.
	if (world->collision_dt == 0.0f)
		world->system.OptimizeBroadPhase();
	world->collision_dt = dt / float(world->collision_steps);
	EPhysicsUpdateError errors = EPhysicsUpdateError::None;
	for (uint32_t left = world->collision_steps; left > 0;)
	{
		uint32_t steps = std::min(left, world->max_collision_steps);
		float update_dt = float(steps) * world->collision_dt;
		errors = errors | world->system.Update(update_dt, int(steps), &world->temp_allocator, world->jobs.get());
		left -= steps;
	}
	return uint32_t(errors);
}

void jolt_world_set_gravity(JoltWorld *world, JoltVec3 gravity)
{
	world->system.SetGravity(ToJolt(gravity));
	for (Body *body : world->bodies)
		if (body != nullptr && !body->IsStatic())
			world->system.GetBodyInterfaceNoLock().ActivateBody(body->GetID());
}

JoltShape *jolt_shape_ball(float radius) { return Owned(new SphereShape(radius)); }

JoltShape *jolt_shape_box(JoltVec3 half_extents)
{
	Vec3 half = ToJolt(half_extents);
	return Owned(new BoxShape(half, ConvexRadius(half.ReduceMin())));
}

JoltShape *jolt_shape_capsule(float half_height, float radius) { return Owned(new CapsuleShape(half_height, radius)); }

JoltShape *jolt_shape_cylinder(float half_height, float radius)
{
	return Owned(new CylinderShape(half_height, radius, ConvexRadius(std::min(half_height, radius))));
}

JoltShape *jolt_shape_hull(const JoltVec3 *points, size_t count)
{
	Array<Vec3> corners;
	for (size_t i = 0; i < count; ++i)
		corners.push_back(ToJolt(points[i]));
	return OwnedIfValid(ConvexHullShapeSettings(corners).Create());
}

JoltShape *jolt_shape_placed(const JoltShape *shape, JoltFrame frame)
{
	return Owned(new RotatedTranslatedShape(ToJolt(frame.position), ToJolt(frame.rotation), Borrowed(shape)));
}

JoltShape *jolt_shape_compound(const JoltShape *const *shapes, size_t count)
{
	StaticCompoundShapeSettings settings;
	for (size_t i = 0; i < count; ++i)
	{
		if (shapes[i] == nullptr)
			return nullptr;
		settings.AddShape(Vec3::sZero(), Quat::sIdentity(), Borrowed(shapes[i]));
	}
	return OwnedIfValid(settings.Create());
}

void jolt_shape_release(JoltShape *shape) { Borrowed(shape)->Release(); }

uint32_t jolt_body_create(JoltWorld *world, const JoltShape *shape, const JoltBodyDef *def)
{
	bool moving = def->motion != JOLT_STATIC;
	RefConst<Shape> form = Borrowed(shape);
	if (def->motion == JOLT_DYNAMIC)
	{
		Vec3 offset = ToJolt(def->mass.center) - form->GetCenterOfMass();
		if (offset != Vec3::sZero())
			form = new OffsetCenterOfMassShape(form, offset);
	}
	EMotionType motion = def->motion == JOLT_DYNAMIC? EMotionType::Dynamic : moving? EMotionType::Kinematic : EMotionType::Static;
	ObjectLayer layer = world->layers.Of({ moving, def->member_of, def->collides_with });
	BodyCreationSettings settings(form, RVec3(ToJolt(def->frame.position)), ToJolt(def->frame.rotation), motion, layer);
	settings.mLinearVelocity = ToJolt(def->linear_velocity);
	settings.mAngularVelocity = ToJolt(def->angular_velocity);
	settings.mFriction = def->friction;
	settings.mRestitution = def->restitution;
	settings.mLinearDamping = def->linear_damping;
	settings.mAngularDamping = def->angular_damping;
	settings.mGravityFactor = def->gravity_factor;
	settings.mAllowedDOFs = EAllowedDOFs(def->allowed_axes);
	settings.mMotionQuality = def->continuous? EMotionQuality::LinearCast : EMotionQuality::Discrete;
	settings.mAllowSleeping = def->allow_sleeping;
	settings.mApplyGyroscopicForce = true;
	if (def->motion == JOLT_DYNAMIC)
	{
		const float *inertia = def->mass.inertia;
		settings.mOverrideMassProperties = EOverrideMassProperties::MassAndInertiaProvided;
		settings.mMassPropertiesOverride.mMass = def->mass.mass;
		settings.mMassPropertiesOverride.mInertia = Mat44(
			Vec4(inertia[0], inertia[1], inertia[2], 0), Vec4(inertia[3], inertia[4], inertia[5], 0),
			Vec4(inertia[6], inertia[7], inertia[8], 0), Vec4(0, 0, 0, 1));
	}
	BodyInterface &bodies = world->system.GetBodyInterfaceNoLock();
	Body *body = bodies.CreateBody(settings);
	if (body == nullptr)
		return JOLT_GROUND;
	bodies.AddBody(body->GetID(), moving? EActivation::Activate : EActivation::DontActivate);
	world->bodies.push_back(body);
	return uint32_t(world->bodies.size() - 1);
}

void jolt_body_remove(JoltWorld *world, uint32_t body)
{
	Body *removed = world->bodies[body];
	BodyInterface &bodies = world->system.GetBodyInterfaceNoLock();
	for (Ref<TwoBodyConstraint> &joint : world->joints)
		if (joint != nullptr && (joint->GetBody1() == removed || joint->GetBody2() == removed))
		{
			for (Body *end : { joint->GetBody1(), joint->GetBody2() })
				if (!end->IsStatic())
					bodies.ActivateBody(end->GetID());
			world->system.RemoveConstraint(joint);
			joint = nullptr;
		}
	// What lies on it must notice: Jolt wakes nobody when a body goes.
	AABox around = removed->GetWorldSpaceBounds();
	around.ExpandBy(Vec3::sReplicate(world->system.GetPhysicsSettings().mSpeculativeContactDistance));
	bodies.ActivateBodiesInAABox(around, {}, {});
	bodies.RemoveBody(removed->GetID());
	bodies.DestroyBody(removed->GetID());
	world->bodies[body] = nullptr;
}

JoltFrame jolt_body_frame(const JoltWorld *world, uint32_t body)
{
	const Body &of = *world->bodies[body];
	return { FromJolt(Vec3(of.GetPosition())), FromJolt(of.GetRotation()) };
}

JoltVec3 jolt_body_linear_velocity(const JoltWorld *world, uint32_t body)
{
	return FromJolt(world->bodies[body]->GetLinearVelocity());
}

JoltVec3 jolt_body_angular_velocity(const JoltWorld *world, uint32_t body)
{
	return FromJolt(world->bodies[body]->GetAngularVelocity());
}

void jolt_body_set_linear_velocity(JoltWorld *world, uint32_t body, JoltVec3 velocity)
{
	world->system.GetBodyInterfaceNoLock().SetLinearVelocity(world->bodies[body]->GetID(), ToJolt(velocity));
}

void jolt_body_add_impulse(JoltWorld *world, uint32_t body, JoltVec3 impulse)
{
	world->system.GetBodyInterfaceNoLock().AddImpulse(world->bodies[body]->GetID(), ToJolt(impulse));
}

bool jolt_body_is_active(const JoltWorld *world, uint32_t body) { return world->bodies[body]->IsActive(); }

JoltMass jolt_body_mass(const JoltWorld *world, uint32_t body)
{
	const Body &of = *world->bodies[body];
	const MotionProperties *motion = of.GetMotionProperties();
	Mat44 axes = Mat44::sRotation(motion->GetInertiaRotation());
	Mat44 inertia = axes * Mat44::sScale(motion->GetInverseInertiaDiagonal().Reciprocal()) * axes.Transposed();
	JoltMass mass { 1.0f / motion->GetInverseMass(), FromJolt(of.GetShape()->GetCenterOfMass()), {} };
	for (uint column = 0; column < 3; ++column)
		for (uint row = 0; row < 3; ++row)
			mass.inertia[3 * column + row] = inertia(row, column);
	return mass;
}

uint32_t jolt_joint_create(JoltWorld *world, const JoltJointDef *def)
{
	Ref<TwoBodyConstraint> joint = CreateConstraint(*def, world->BodyOf(def->a), world->BodyOf(def->b));
	world->system.AddConstraint(joint);
	world->joints.push_back(joint);
	if (!def->collide_connected && def->a != JOLT_GROUND && def->b != JOLT_GROUND)
		world->Separate(def->a, def->b);
	return uint32_t(world->joints.size() - 1);
}

bool jolt_joint_force(const JoltWorld *world, uint32_t joint, JoltVec3 *force)
{
	const TwoBodyConstraint *of = world->joints[joint];
	if (of == nullptr || world->collision_dt == 0.0f)
		return false;
	Vec3 impulse;
	switch (of->GetSubType())
	{
	case EConstraintSubType::Fixed:
		impulse = static_cast<const FixedConstraint *>(of)->GetTotalLambdaPosition();
		break;
	case EConstraintSubType::Hinge:
		impulse = static_cast<const HingeConstraint *>(of)->GetTotalLambdaPosition();
		break;
	case EConstraintSubType::Point:
		impulse = static_cast<const PointConstraint *>(of)->GetTotalLambdaPosition();
		break;
	case EConstraintSubType::Distance:
		{
			RVec3 point_a = of->GetBody1()->GetCenterOfMassTransform() * of->GetConstraintToBody1Matrix().GetTranslation();
			RVec3 point_b = of->GetBody2()->GetCenterOfMassTransform() * of->GetConstraintToBody2Matrix().GetTranslation();
			Vec3 direction = Vec3(point_b - point_a).NormalizedOr(Vec3::sZero());
			impulse = static_cast<const DistanceConstraint *>(of)->GetTotalLambdaPosition() * direction;
			break;
		}
	default:
		return false;
	}
	*force = FromJolt(impulse / world->collision_dt);
	return true;
}
