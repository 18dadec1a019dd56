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

#include <cmath>
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
        throw Error(result, ls_last_error_message_get());
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

struct LongRangeDef : LsLongRangeDef {
    LongRangeDef() { check(ls_long_range_def_init(this, sizeof(LsLongRangeDef))); }
};

struct StreamDef : LsStreamDef {
    explicit StreamDef(const char *name_) {
        check(ls_stream_def_init(this, sizeof(LsStreamDef)));
        name = name_;
    }
};

struct StreamReaderDef : LsStreamReaderDef {
    StreamReaderDef() { check(ls_stream_reader_def_init(this, sizeof(LsStreamReaderDef))); }
    static StreamReaderDef of_stream(const char *name) {
        StreamReaderDef def;
        def.name = name;
        return def;
    }
    static StreamReaderDef of_recording(const char *file) {
        StreamReaderDef def;
        def.recording = file;
        return def;
    }
};

/// Draws what a world holds; see World::draw. Its functions must not throw: they are called from C.
class Painter {
public:
    virtual ~Painter() = default;
    virtual void line(const double * /*from*/, const double * /*to*/, std::uint32_t /*color*/) noexcept {}
    virtual void triangle(const double * /*corners*/, std::uint32_t /*color*/) noexcept {}
    virtual void text(const double * /*at*/, const char * /*words*/, std::uint32_t /*color*/) noexcept {}
};

/// What an LsDraw is made of; hands every primitive to a painter.
struct Draw : LsDraw {
    Draw(Painter &painter, std::uint32_t layers_) {
        check(ls_draw_init(this, sizeof(LsDraw)));
        layers = layers_;
        user = &painter;
        line = [](const double *from, const double *to, std::uint32_t color, void *to_whom) {
            static_cast<Painter *>(to_whom)->line(from, to, color);
        };
        triangle = [](const double *corners, std::uint32_t color, void *to_whom) {
            static_cast<Painter *>(to_whom)->triangle(corners, color);
        };
        text = [](const double *at, const char *words, std::uint32_t color, void *to_whom) {
            static_cast<Painter *>(to_whom)->text(at, words, color);
        };
    }
};

/// A solid cut into bodies, and the joints between them.
struct Cells {
    std::vector<LsBody> bodies;
    std::vector<LsJoint> joints;
};

namespace detail {

/// What a function hands out as an array of its own, valid as long as its C function says.
template <typename T, typename Owner>
Span<T> array(LsResult (*function)(Owner, const T **, std::size_t *), Owner owner) {
    const T *elements = nullptr;
    std::size_t count = 0;
    check(function(owner, &elements, &count));
    return Span<T>(elements, count);
}

/// What a function writes into a buffer: asked for its size first, unless a few will do.
template <typename T, typename Fill>
std::vector<T> listed(Fill fill) {
    std::vector<T> list(16);
    std::size_t count = 0;
    LsResult result = fill(list.data(), list.size(), &count);
    while (result == LS_ERROR_BUFFER_TOO_SMALL) {
        list.resize(count);
        result = fill(list.data(), list.size(), &count);
    }
    check(result);
    list.resize(count);
    return list;
}

} // namespace detail

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
        check(ls_body_impulse_add(world_, body, impulse));
    }
    void set_friction(LsJoint joint, float friction) { check(ls_joint_friction_set(world_, joint, friction)); }
    LsJointState state(LsJoint joint) const {
        LsJointState state;
        check(ls_joint_state_get(world_, joint, &state, sizeof state));
        return state;
    }
    LsJointAxisState axis_state(LsJoint joint, uint32_t axis) const {
        LsJointAxisState state;
        check(ls_joint_axis_state_get(world_, joint, axis, &state, sizeof state));
        return state;
    }

    std::vector<LsBody> bodies() const { return list<LsBody>(ls_world_bodies_get); }
    std::vector<LsJoint> joints() const { return list<LsJoint>(ls_world_joints_get); }
    std::vector<LsContact> contacts() const { return list<LsContact>(ls_world_contacts_get); }
    std::vector<LsShape> shapes(LsBody body) const { return list<LsShape>(ls_body_shapes_get, body); }
    std::vector<LsJoint> joints(LsBody body) const { return list<LsJoint>(ls_body_joints_get, body); }
    std::vector<LsContact> contacts(LsBody body) const { return list<LsContact>(ls_body_contacts_get, body); }

    /// Arrays of the last step, valid until the next one.
    Span<LsMoved> moved() const { return array<LsMoved>(ls_world_moved_bodies_get); }
    Span<LsContactPair> contact_began() const { return array<LsContactPair>(ls_world_contacts_begun_get); }
    Span<LsContactPair> contact_ended() const { return array<LsContactPair>(ls_world_contacts_ended_get); }
    Span<LsJointOverload> overloaded() const { return array<LsJointOverload>(ls_world_overloaded_joints_get); }
    Span<LsBody> quarantined() const { return array<LsBody>(ls_world_quarantined_bodies_get); }
    Span<LsArticulation> articulations() const { return array<LsArticulation>(ls_world_articulations_get); }
    Span<LsHit> hits() const { return array<LsHit>(ls_world_hits_get); }
    Span<LsJointStop> joint_stops() const { return array<LsJointStop>(ls_world_joint_stops_get); }
    Span<LsContactPair> sensor_began() const { return array<LsContactPair>(ls_world_sensor_overlaps_begun_get); }
    Span<LsContactPair> sensor_ended() const { return array<LsContactPair>(ls_world_sensor_overlaps_ended_get); }
    Span<LsContactPair> sensed() const { return array<LsContactPair>(ls_world_sensor_overlaps_get); }
    Span<LsJointBreak> broken() const { return array<LsJointBreak>(ls_world_joint_breaks_get); }
    Span<LsSplit> splits() const { return array<LsSplit>(ls_world_splits_get); }
    Span<LsPiece> pieces() const { return array<LsPiece>(ls_world_pieces_get); }
    Span<LsBody> piece_bodies() const { return array<LsBody>(ls_world_piece_bodies_get); }

    /// What joints bear. `create_cells` cuts a box or convex hull along the cells of these seeds (x, y, z of each, in its frame); it throws
    /// where their number is no multiple of three.
    void set_strength(LsJoint joint, const LsStrength &strength) { check(ls_joint_strength_set(world_, joint, &strength)); }
    LsJointStress stress(LsJoint joint) const {
        LsJointStress stress;
        check(ls_joint_stress_get(world_, joint, &stress, sizeof stress));
        return stress;
    }
    void apply_fractures(Span<LsJoint> joints) { check(ls_world_fractures_apply(world_, joints.data(), joints.size())); }
    std::vector<LsJoint> near_breaking(float least) const { return list<LsJoint>(ls_world_joints_near_breaking_get, least); }
    Cells create_cells(const LsBodyDef &body, const LsShapeDef &shape, const std::vector<float> &seeds, const LsBondMaterial &material) {
        if (seeds.size() % 3 != 0) {
            throw Error(LS_ERROR_OUT_OF_RANGE, "create_cells: seeds: is not three numbers for each");
        }
        const std::size_t count = seeds.size() / 3;
        Cells cells{std::vector<LsBody>(count), std::vector<LsJoint>(count * 8)};
        std::size_t body_count = 0, joint_count = 0;
        const auto cut = [&] {
            return ls_world_cells_create(world_, &body, &shape, seeds.data(), count, &material, cells.bodies.data(), cells.bodies.size(),
                                         &body_count, cells.joints.data(), cells.joints.size(), &joint_count);
        };
        LsResult result = cut();
        if (result == LS_ERROR_BUFFER_TOO_SMALL) {
            cells.joints.resize(joint_count > cells.joints.size() ? joint_count : cells.joints.size() * 4);
            result = cut();
        }
        check(result);
        cells.bodies.resize(body_count);
        cells.joints.resize(joint_count);
        return cells;
    }

    /// What fixed joints make one body; a body of no union has one of a null lead.
    LsUnion union_of(LsBody body) const {
        LsUnion found;
        check(ls_body_union_get(world_, body, &found));
        return found;
    }
    std::vector<LsBody> union_members(LsBody body) const { return list<LsBody>(ls_body_union_members_get, body); }
    std::vector<LsUnion> unions() const { return list<LsUnion>(ls_world_unions_get); }

    /// Long-range constraints.
    LongRangeDef long_range() const {
        LongRangeDef def;
        check(ls_world_long_range_get(world_, &def, sizeof(LsLongRangeDef)));
        return def;
    }
    void set_long_range(const LsLongRangeDef &def) { check(ls_world_long_range_set(world_, &def)); }
    void set_soft_bound(LsJoint a, LsJoint b, const LsSoftBound &bound) { check(ls_world_soft_bound_set(world_, a, b, &bound)); }
    void remove_soft_bound(LsJoint a, LsJoint b) { check(ls_world_soft_bound_remove(world_, a, b)); }
    std::vector<LsBound> bounds() const { return list<LsBound>(ls_world_bounds_get); }

    /// What holds bodies up, once it is switched on.
    void enable_support(bool on = true) { check(ls_support_enabled_set(world_, on)); }
    LsSupport support(LsBody body) const {
        LsSupport support;
        check(ls_support_get(world_, &body, 1, &support));
        return support;
    }
    std::vector<LsSupportChange> support_changes() const { return list<LsSupportChange>(ls_support_changes_get); }
    std::vector<LsBody> supporters(LsBody body) const { return list<LsBody>(ls_support_carriers_get, body); }
    std::vector<LsBody> supported_by(LsBody body) const { return list<LsBody>(ls_support_carried_get, body); }
    std::vector<LsBody> path_to_ground(LsBody body) const { return list<LsBody>(ls_support_path_get, body); }
    std::vector<LsBody> lost_without(Span<LsBody> removed) const {
        return list<LsBody>(ls_support_loss_predict, removed.data(), removed.size());
    }

    /// Hands the layers (LS_DRAW_) of what the world holds to a painter.
    void draw(Painter &painter, std::uint32_t layers) const {
        const Draw order(painter, layers);
        draw(order);
    }
    void draw(const LsDraw &order) const { check(ls_world_draw(world_, &order)); }

    /// The first shape that a ray meets; its shape is null if there is none.
    LsRayHit cast_ray(const LsRay &ray, const LsQueryFilter *filter = nullptr) const {
        LsRayHit hit;
        check(ls_world_ray_cast(world_, &ray, filter, &hit));
        return hit;
    }

    std::vector<LsRayHit> cast_ray_all(const LsRay &ray, const LsQueryFilter *filter = nullptr) const {
        return list<LsRayHit>(ls_world_ray_cast_all, &ray, filter);
    }
    std::vector<LsShape> overlap(const LsShapeDef &shape, const LsPose &pose, const LsQueryFilter *filter = nullptr) const {
        return list<LsShape>(ls_world_shape_overlaps_get, &shape, &pose, filter);
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

    /// Writes every change from now on to a file, or behind what is in a vector, which must live until stop_recording.
    void record(const char *file, std::uint32_t flags = 0) { check(ls_world_recording_start_to_file(world_, file, flags)); }
    void record(std::vector<unsigned char> &recording, std::uint32_t flags = 0) {
        const LsRecordCallback append = [](const void *data, std::size_t size, void *user) noexcept -> std::int32_t {
            try {
                const auto *bytes = static_cast<const unsigned char *>(data);
                auto &list = *static_cast<std::vector<unsigned char> *>(user);
                list.insert(list.end(), bytes, bytes + size);
                return 0;
            } catch (...) {
                return 1;
            }
        };
        check(ls_world_recording_start(world_, append, flags, &recording));
    }
    void stop_recording() { check(ls_world_recording_stop(world_)); }

    /// A world in which a recording was played, as far as it goes or for so many steps, and what came of it.
    static std::pair<World, LsReplay> replay(const std::vector<unsigned char> &recording, std::uint64_t most_steps = UINT64_MAX) {
        LsWorld world = {0};
        LsReplay report;
        check(ls_recording_replay(recording.data(), recording.size(), most_steps, &world, &report, sizeof report));
        return {World(world), report};
    }

private:
    explicit World(LsWorld world) noexcept : world_(world) {}

    template <typename T, typename Function, typename... Given>
    std::vector<T> list(Function function, Given... given) const {
        return detail::listed<T>([&](T *out, std::size_t capacity, std::size_t *count) {
            return function(world_, given..., out, capacity, count);
        });
    }
    template <typename T>
    T out(LsResult (*function)(LsWorld, T *)) const {
        T value;
        check(function(world_, &value));
        return value;
    }
    template <typename T>
    Span<T> array(LsResult (*function)(LsWorld, const T **, std::size_t *)) const {
        return detail::array<T>(function, world_);
    }

    LsWorld world_ = {0};
};

/// Shows a world to other processes, until its owner or the world goes. Every call of it throws LS_ERROR_UNSUPPORTED where the
/// library was built without streams.
class Stream {
public:
    Stream(const World &world, const LsStreamDef &def) { check(ls_stream_open(world.get(), &def, &stream_)); }
    Stream(Stream &&other) noexcept : stream_(std::exchange(other.stream_, LsStream{0})) {}
    Stream &operator=(Stream &&other) noexcept {
        std::swap(stream_, other.stream_);
        return *this;
    }
    Stream(const Stream &) = delete;
    Stream &operator=(const Stream &) = delete;
    ~Stream() {
        if (stream_.id != 0) {
            ls_stream_close(stream_);
        }
    }
    LsStream get() const noexcept { return stream_; }
    void serve() { check(ls_stream_serve(stream_)); }
    LsStreamStats stats() const {
        LsStreamStats stats;
        check(ls_stream_stats_get(stream_, &stats, sizeof stats));
        return stats;
    }

private:
    LsStream stream_ = {0};
};

/// Looks at a stream of another process, or at a recording. Arrays are valid until the next poll.
class StreamReader {
public:
    explicit StreamReader(const LsStreamReaderDef &def) { check(ls_stream_reader_open(&def, &reader_)); }
    StreamReader(StreamReader &&other) noexcept : reader_(std::exchange(other.reader_, LsStreamReader{0})) {}
    StreamReader &operator=(StreamReader &&other) noexcept {
        std::swap(reader_, other.reader_);
        return *this;
    }
    StreamReader(const StreamReader &) = delete;
    StreamReader &operator=(const StreamReader &) = delete;
    ~StreamReader() {
        if (reader_.id != 0) {
            ls_stream_reader_close(reader_);
        }
    }
    LsStreamReader get() const noexcept { return reader_; }
    LsStreamPoll poll(float timeout) {
        LsStreamPoll poll;
        check(ls_stream_reader_poll(reader_, timeout, &poll, sizeof poll));
        return poll;
    }
    Span<LsStreamBody> bodies() const { return detail::array<LsStreamBody>(ls_stream_reader_bodies_get, reader_); }
    Span<LsStreamShape> shapes() const { return detail::array<LsStreamShape>(ls_stream_reader_shapes_get, reader_); }
    Span<LsStreamJoint> joints() const { return detail::array<LsStreamJoint>(ls_stream_reader_joints_get, reader_); }
    Span<LsStreamContact> contacts() const { return detail::array<LsStreamContact>(ls_stream_reader_contacts_get, reader_); }
    Span<LsStreamBound> bounds() const { return detail::array<LsStreamBound>(ls_stream_reader_bounds_get, reader_); }
    Span<LsStreamPlane> planes() const { return detail::array<LsStreamPlane>(ls_stream_reader_planes_get, reader_); }
    Span<LsStreamEvent> events() const { return detail::array<LsStreamEvent>(ls_stream_reader_events_get, reader_); }

private:
    LsStreamReader reader_ = {0};
};

/// Turns steps of a fixed length into the time of a host's frames, and says where to draw between two of them.
///
///     for (int due = accumulator.steps(frame_seconds, 4); due > 0; --due) { previous = now; world.step(accumulator.dt()); ... }
///     draw(between(previous, now, accumulator.share()));
class Accumulator {
public:
    explicit Accumulator(float dt) noexcept : dt_(dt) {}
    float dt() const noexcept { return dt_; }
    /// Adds the frame's time, and returns how many steps are due, 0 to `most`: time beyond that is dropped. A clock that has gone back, or a
    /// time that is no number, adds none.
    int steps(double frame_seconds, int most) noexcept {
        rest_ += frame_seconds > 0.0 ? frame_seconds : 0.0;
        const double due = std::floor(rest_ / dt_);
        if (!(due < most)) {
            // Of the time beyond, what is less than a step stays, so that the picture goes on where it was between two steps.
            rest_ = std::fmod(rest_, dt_);
            rest_ = rest_ >= 0.0 ? rest_ : 0.0;
            return most > 0 ? most : 0;
        }
        rest_ -= due * dt_;
        return static_cast<int>(due);
    }
    /// How far now is from the last step to the next one, 0 to 1.
    float share() const noexcept { return static_cast<float>(rest_ / dt_); }

private:
    float dt_;
    double rest_ = 0.0;
};

} // namespace longspan

#endif
