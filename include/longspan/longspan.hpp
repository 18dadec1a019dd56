// longspan for C++17: the C interface with owners, spans and exceptions. Header only; nothing here is more than a call.
//
//     longspan::World world;
//     longspan::ShapeDef shape(LS_SHAPE_BOX);
//     LsBody box = world.create_body(longspan::BodyDef(LS_BODY_DYNAMIC).at(0, 3, 0).with(shape));
//     world.step(1.0f / 60.0f);
//     double height = world.pose(box).position[1];
//
// A World owns its bodies; handles (LsBody, LsShape, LsJoint) are plain values. A call that fails throws longspan::Error, which
// has the code and the message. The C functions work on the same handles: world.get() is the LsWorld. What is not wrapped here is
// called so, through longspan::check:
//
//     longspan::check(ls_body_damping_set(world.get(), box, 0.1f, 0.1f));
#ifndef LONGSPAN_HPP
#define LONGSPAN_HPP

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "longspan.h"

namespace longspan {

/// A call that failed: its LS_ERROR_ code, and the message that names the argument at fault.
class Error : public std::runtime_error {
public:
    Error(LsResult code, const char *message) : std::runtime_error(message), code_(code) {}
    LsResult code() const noexcept { return code_; }

private:
    LsResult code_;
};

/// Throws if a call failed.
inline void check(LsResult result) {
    if (result != LS_OK) {
        throw Error(result, ls_last_error_message());
    }
}

/// Elements that somebody else owns.
template <typename T>
class Span {
public:
    Span() noexcept = default;
    Span(const T *data, std::size_t size) noexcept : data_(data), size_(size) {}
    const T *begin() const noexcept { return data_; }
    const T *end() const noexcept { return data_ + size_; }
    const T *data() const noexcept { return data_; }
    std::size_t size() const noexcept { return size_; }
    bool empty() const noexcept { return size_ == 0; }
    const T &operator[](std::size_t index) const noexcept { return data_[index]; }

private:
    const T *data_ = nullptr;
    std::size_t size_ = 0;
};

struct WorldDef : LsWorldDef {
    WorldDef() { check(ls_world_def_init(this, sizeof(LsWorldDef))); }
};

struct ShapeDef : LsShapeDef {
    explicit ShapeDef(std::int32_t kind_) {
        check(ls_shape_def_init(this, sizeof(LsShapeDef)));
        kind = kind_;
    }
};

struct JointDef : LsJointDef {
    JointDef(std::int32_t kind_, LsBody a, LsBody b) {
        check(ls_joint_def_init(this, sizeof(LsJointDef)));
        kind = kind_;
        body_a = a;
        body_b = b;
    }
    JointDef &at(double ax, double ay, double az, double bx, double by, double bz) noexcept {
        const double on_a[3] = {ax, ay, az}, on_b[3] = {bx, by, bz};
        for (int axis = 0; axis < 3; ++axis) {
            frame_a.position[axis] = on_a[axis];
            frame_b.position[axis] = on_b[axis];
        }
        return *this;
    }
};

struct BodyDef : LsBodyDef {
    explicit BodyDef(std::int32_t kind_) {
        check(ls_body_def_init(this, sizeof(LsBodyDef)));
        kind = kind_;
    }
    BodyDef &at(double x, double y, double z) noexcept {
        pose.position[0] = x;
        pose.position[1] = y;
        pose.position[2] = z;
        return *this;
    }
    /// The shape must live until the body is created.
    BodyDef &with(const LsShapeDef &shape) noexcept {
        shapes = &shape;
        shape_count = 1;
        return *this;
    }
};

struct QueryFilter : LsQueryFilter {
    QueryFilter() { check(ls_query_filter_init(this, sizeof(LsQueryFilter))); }
};

/// A world, destroyed with its owner.
class World {
public:
    World() : World(WorldDef()) {}
    explicit World(const LsWorldDef &def) { check(ls_world_create(&def, &world_)); }
    World(World &&other) noexcept : world_(std::exchange(other.world_, LsWorld{0})) {}
    World &operator=(World &&other) noexcept {
        std::swap(world_, other.world_);
        return *this;
    }
    World(const World &) = delete;
    World &operator=(const World &) = delete;
    ~World() {
        if (world_.id != 0) {
            ls_world_destroy(world_);
        }
    }

    /// For every function of the C interface.
    LsWorld get() const noexcept { return world_; }

    void step(float dt) { check(ls_world_step(world_, dt)); }
    double time() const { return out<double>(ls_world_time_get); }
    std::uint64_t state_hash() const { return out<std::uint64_t>(ls_world_state_hash_get); }
    LsStepReport report() const {
        LsStepReport report;
        check(ls_world_report_get(world_, &report, sizeof report));
        return report;
    }

    LsBody create_body(const LsBodyDef &def) {
        LsBody body;
        check(ls_body_create(world_, &def, &body));
        return body;
    }
    LsShape attach(LsBody body, const LsShapeDef &def) {
        LsShape shape;
        check(ls_shape_attach(world_, body, &def, &shape));
        return shape;
    }
    LsJoint create_joint(const LsJointDef &def) {
        LsJoint joint;
        check(ls_joint_create(world_, &def, &joint));
        return joint;
    }
    void destroy(LsBody body) { check(ls_body_destroy(world_, body)); }
    void destroy(LsShape shape) { check(ls_shape_destroy(world_, shape)); }
    void destroy(LsJoint joint) { check(ls_joint_destroy(world_, joint)); }

    LsPose pose(LsBody body) const {
        LsPose pose;
        check(ls_body_pose_get(world_, body, &pose));
        return pose;
    }
    void set_pose(LsBody body, const LsPose &pose) { check(ls_body_pose_set(world_, body, &pose)); }
    void add_impulse(LsBody body, float x, float y, float z) {
        const float impulse[3] = {x, y, z};
        check(ls_body_add_impulse(world_, body, impulse));
    }
    LsJointState state(LsJoint joint) const {
        LsJointState state;
        check(ls_joint_state_get(world_, joint, &state, sizeof state));
        return state;
    }

    /// Arrays of the last step, valid until the next one.
    Span<LsMoved> moved() const { return array<LsMoved>(ls_world_moved); }
    Span<LsContactPair> contact_began() const { return array<LsContactPair>(ls_world_contact_began); }
    Span<LsContactPair> contact_ended() const { return array<LsContactPair>(ls_world_contact_ended); }
    Span<LsJointOverload> overloaded() const { return array<LsJointOverload>(ls_world_overloaded); }
    Span<LsBody> quarantined() const { return array<LsBody>(ls_world_quarantined); }

    /// The first shape that a ray meets; its shape is null if there is none.
    LsRayHit cast_ray(const LsRay &ray, const LsQueryFilter *filter = nullptr) const {
        LsRayHit hit;
        check(ls_world_cast_ray(world_, &ray, filter, &hit));
        return hit;
    }

    /// The whole world as bytes; the vector's memory is used again.
    void save(std::vector<unsigned char> &snapshot) const {
        std::size_t size = 0;
        snapshot.resize(snapshot.capacity());
        LsResult result = ls_world_save(world_, snapshot.data(), snapshot.size(), &size);
        if (result == LS_ERROR_BUFFER_TOO_SMALL) {
            snapshot.resize(size);
            result = ls_world_save(world_, snapshot.data(), snapshot.size(), &size);
        }
        check(result);
        snapshot.resize(size);
    }
    void restore(const std::vector<unsigned char> &snapshot) { check(ls_world_restore(world_, snapshot.data(), snapshot.size())); }

private:
    template <typename T>
    T out(LsResult (*function)(LsWorld, T *)) const {
        T value;
        check(function(world_, &value));
        return value;
    }
    template <typename T>
    Span<T> array(LsResult (*function)(LsWorld, const T **, std::size_t *)) const {
        const T *elements = nullptr;
        std::size_t count = 0;
        check(function(world_, &elements, &count));
        return Span<T>(elements, count);
    }

    LsWorld world_ = {0};
};

/// Turns steps of a fixed length into the time of a host's frames, and says where to draw between two of them.
///
///     for (int due = accumulator.steps(frame_seconds, 4); due > 0; --due) { previous = now; world.step(accumulator.dt()); ... }
///     draw(between(previous, now, accumulator.share()));
class Accumulator {
public:
    explicit Accumulator(float dt) noexcept : dt_(dt) {}
    float dt() const noexcept { return dt_; }
    /// Adds the frame's time, and returns how many steps are due, at most `most`: time beyond that is dropped.
    int steps(double frame_seconds, int most) noexcept {
        rest_ += frame_seconds;
        int due = static_cast<int>(rest_ / dt_);
        rest_ -= static_cast<double>(due) * dt_;
        return due < most ? due : most;
    }
    /// How far now is from the last step to the next one, 0 to 1.
    float share() const noexcept { return static_cast<float>(rest_ / dt_); }

private:
    float dt_;
    double rest_ = 0.0;
};

} // namespace longspan

#endif
