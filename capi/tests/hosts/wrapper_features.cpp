// What the C++ wrapper has for the rest of the library: unions, fracture, support, long-range bounds, drawing, recordings, streams.
#include <cmath>
#include <cstdio>
#include <cstring>

#include "longspan/longspan.hpp"

static int failures = 0;

static void expect(bool holds, const char *what) {
    if (!holds) {
        std::printf("not so: %s\n", what);
        ++failures;
    }
}

class Counter : public longspan::Painter {
public:
    void line(const double *, const double *, std::uint32_t) noexcept override { ++lines; }
    void text(const double *, const char *words, std::uint32_t) noexcept override {
        std::strncpy(last, words, sizeof last - 1);
    }
    int lines = 0;
    char last[64] = "";
};

static void chains_and_unions() {
    longspan::World world;
    longspan::ShapeDef cube(LS_SHAPE_BOX);
    const longspan::BodyDef def(LS_BODY_DYNAMIC);
    std::vector<LsJoint> joints;
    LsBody last = {0};
    for (int i = 0; i < 20; ++i) {
        longspan::BodyDef link = def;
        const LsBody next = world.create_body(link.at(0, -0.5 - i, 0).with(cube));
        joints.push_back(world.create_joint(longspan::JointDef(LS_JOINT_SPHERICAL, last, next).at(0, i == 0 ? 0 : -0.5, 0, 0, 0.5, 0)));
        last = next;
    }
    longspan::BodyDef welded = def;
    const LsBody a = world.create_body(welded.at(9, 0, 0).with(cube)), b = world.create_body(welded.at(10, 0, 0).with(cube));
    world.create_joint(longspan::JointDef(LS_JOINT_FIXED, a, b).at(0.5, 0, 0, -0.5, 0, 0));
    world.step(1.0f / 60.0f);

    expect(world.bodies().size() == 22 && world.joints().size() == 21, "lists longer than a first guess are whole");
    expect(world.joints(last).size() == 1 && world.shapes(last).size() == 1, "lists of a body");
    expect(world.unions().size() == 1 && world.union_members(a).size() == 2, "two welded boxes are a union");
    expect(world.union_of(b).lead.id == a.id && std::fabs(world.union_of(a).center[0] - 9.5) < 1e-3, "it is halfway between");
    expect(world.bounds().size() >= 19, "a chain has bounds");
    Counter counter;
    world.draw(counter, LS_DRAW_UNIONS);
    expect(counter.lines == 5 && std::strcmp(counter.last, "2 bodies") == 0, "a union is drawn");
    longspan::LongRangeDef none = world.long_range();
    none.enabled = 0;
    world.set_long_range(none);
    world.step(1.0f / 60.0f);
    expect(world.bounds().empty(), "none once they are off");
    counter.lines = 0;
    world.draw(counter, LS_DRAW_UNIONS);
    expect(world.unions().empty() && counter.lines == 0, "and no union is drawn");
    counter.lines = 0;
    world.draw(counter, LS_DRAW_JOINTS);
    expect(counter.lines > 100, "joints are drawn");
}

static void walls_and_support() {
    longspan::World world;
    world.enable_support();
    longspan::ShapeDef plane(LS_SHAPE_HALF_SPACE), cube(LS_SHAPE_BOX), wall(LS_SHAPE_BOX);
    const LsBody ground = world.create_body(longspan::BodyDef(LS_BODY_STATIC).with(plane));
    const LsBody lower = world.create_body(longspan::BodyDef(LS_BODY_DYNAMIC).at(-5, 0.5, 0).with(cube));
    const LsBody upper = world.create_body(longspan::BodyDef(LS_BODY_DYNAMIC).at(-5, 1.5, 0).with(cube));
    std::vector<float> seeds(3 * 12);
    longspan::check(ls_cell_seeds_get(&wall, 12, 7, seeds.data()));
    const LsBondMaterial mortar = {2e5f, 2e6f, 2e5f, 1.0f / 60.0f, 0, 0.5f, 1.0f, 1e9f};
    const longspan::Cells cells = world.create_cells(longspan::BodyDef(LS_BODY_DYNAMIC).at(5, 0.5, 0), wall, seeds, mortar);
    expect(cells.bodies.size() == 12 && cells.joints.size() >= 11, "a wall of twelve cells");
    seeds.pop_back();
    try {
        world.create_cells(longspan::BodyDef(LS_BODY_DYNAMIC), wall, seeds, mortar);
        expect(false, "seeds that are no points throw");
    } catch (const longspan::Error &error) {
        expect(error.code() == LS_ERROR_OUT_OF_RANGE, "seeds that are no points are out of range");
    }
    for (int i = 0; i < 20; ++i) {
        world.step(1.0f / 60.0f);
    }
    expect(world.support(upper).verdict == LS_SUPPORT_SUPPORTED, "the upper box is held up");
    const std::vector<LsBody> carriers = world.supporters(upper), way = world.path_to_ground(upper);
    expect(carriers.size() == 1 && carriers[0].id == lower.id, "by the lower one");
    expect(way.size() == 3 && way[2].id == ground.id, "which stands on the ground");
    expect(world.lost_without(longspan::Span<LsBody>(&lower, 1)).size() >= 1, "and would fall without it");
    expect(world.contacts(upper).size() == 1 && world.contacts().size() >= 2, "contacts of a body, and all");
    expect(world.stress(cells.joints[0]).share < 1.0f && world.near_breaking(1.0f).empty(), "the wall holds");

    std::vector<unsigned char> recording;
    world.record(recording);
    world.apply_fractures(longspan::Span<LsJoint>(cells.joints.data(), cells.joints.size()));
    world.step(1.0f / 60.0f);
    expect(world.broken().size() == cells.joints.size() && world.splits().size() == 1, "all of it breaks at once");
    expect(world.pieces().size() == 12 && world.piece_bodies().size() == 12, "into its cells");
    world.step(1.0f / 60.0f);
    world.stop_recording();
    auto [played, report] = longspan::World::replay(recording);
    expect(report.diverged == 0 && report.steps == 2 && played.state_hash() == world.state_hash(), "played to the same bits");
}

/// Verdict after a second on one of two cards that lean on each other by 0.3 rad.
static std::int32_t leaning_cards(bool by_thrust) {
    longspan::WorldDef def;
    def.support = 1;
    def.support_by_thrust = by_thrust;
    longspan::World world(def);
    longspan::ShapeDef plane(LS_SHAPE_HALF_SPACE), card(LS_SHAPE_BOX);
    card.half_extents[0] = 0.05f;
    world.create_body(longspan::BodyDef(LS_BODY_STATIC).with(plane));
    const float sin = std::sin(0.3f), cos = std::cos(0.3f);
    LsBody left{};
    for (const float side : {1.0f, -1.0f}) {
        longspan::BodyDef body(LS_BODY_DYNAMIC);
        body.at(side * (0.05f * cos + 0.5f * sin), 0.05f * sin + 0.5f * cos, 0).with(card);
        body.pose.rotation[2] = side * std::sin(0.15f);
        body.pose.rotation[3] = std::cos(0.15f);
        left = world.create_body(body);
    }
    for (int i = 0; i < 60; ++i) {
        world.step(1.0f / 60.0f);
    }
    return world.support(left).verdict;
}

static void thrust() {
    expect(leaning_cards(true) == LS_SUPPORT_BRACED, "cards brace each other");
    expect(leaning_cards(false) == LS_SUPPORT_OUTSIDE_HULL, "and are loose by projection");
}

static void streams() {
    longspan::World world;
    try {
        longspan::Stream stream(world, longspan::StreamDef("wrapper"));
        world.step(1.0f / 60.0f);
        expect(stream.stats().frames >= 1, "a frame was published");
        longspan::StreamReader reader(longspan::StreamReaderDef::of_stream("wrapper"));
        expect(reader.bodies().empty(), "an empty world");
    } catch (const longspan::Error &error) {
        expect(error.code() == LS_ERROR_UNSUPPORTED, "a library without streams says so");
    }
}

int main() {
    chains_and_unions();
    walls_and_support();
    thrust();
    streams();
    std::printf("%d failures\n", failures);
    return failures == 0 ? 0 : 1;
}
