// The C++ wrapper: owners, errors, spans, snapshots, fixed steps.
#include <cmath>
#include <cstdio>
#include <type_traits>

#include "longspan/longspan.hpp"

static_assert(!std::is_copy_constructible<longspan::World>::value, "a world has one owner");
static_assert(sizeof(longspan::World) == sizeof(LsWorld), "an owner is no larger than its handle");

static int failures = 0;

static void expect(bool holds, const char *what) {
    if (!holds) {
        std::printf("not so: %s\n", what);
        ++failures;
    }
}

int main() {
    longspan::World world;
    longspan::ShapeDef plane(LS_SHAPE_HALF_SPACE), cube(LS_SHAPE_BOX);
    world.create_body(longspan::BodyDef(LS_BODY_STATIC).with(plane));
    const LsBody box = world.create_body(longspan::BodyDef(LS_BODY_DYNAMIC).at(0, 3, 0).with(cube));
    const LsBody hung = world.create_body(longspan::BodyDef(LS_BODY_DYNAMIC).at(5, 3, 0).with(cube));
    const LsJoint joint = world.create_joint(longspan::JointDef(LS_JOINT_SPHERICAL, LsBody{0}, hung).at(5, 4, 0, 0, 1, 0));

    longspan::Accumulator accumulator(1.0f / 60.0f);
    int steps = 0;
    for (int frame = 0; frame < 288; ++frame) {
        for (int due = accumulator.steps(1.0 / 144.0, 4); due > 0; --due) {
            world.step(accumulator.dt());
            ++steps;
        }
        expect(accumulator.share() >= 0.0f && accumulator.share() <= 1.0f, "the share is one");
    }
    expect(steps >= 119 && steps <= 120, "2 s are 120 steps");
    longspan::Accumulator strange(1.0f / 60.0f);
    for (const double frame : {4e7, 1e300, static_cast<double>(INFINITY)}) {
        expect(strange.steps(frame, 4) == 4, "of a frame however long at most these steps are due");
        expect(strange.share() >= 0.0f && strange.share() <= 1.0f, "the share is one after it");
    }
    expect(strange.steps(-0.1, 4) == 0 && strange.steps(static_cast<double>(NAN), 4) == 0, "no time makes no steps");
    expect(strange.steps(1.5 / 60.0, 4) <= 2 && strange.share() >= 0.0f, "and the next frame is as any other");
    expect(std::fabs(world.pose(box).position[1] - 0.5) < 1e-3, "the box lies on the ground");
    expect(std::fabs(world.state(joint).force[1] - 9810.0f) < 200.0f, "the joint carries the other box");
    expect(world.report().step == static_cast<std::uint64_t>(steps), "the report counts them");

    const LsRay down = {{0, 10, 0}, {0, -1, 0}, 20};
    expect(world.cast_ray(down).body.id == box.id, "a ray from above meets the box");

    std::vector<unsigned char> snapshot;
    world.save(snapshot);
    world.add_impulse(box, 0, 5000, 0);
    world.step(accumulator.dt());
    const std::uint64_t hash = world.state_hash();
    expect(!world.moved().empty() && world.moved()[0].user_word == 0, "something moved");
    world.restore(snapshot);
    world.add_impulse(box, 0, 5000, 0);
    world.step(accumulator.dt());
    expect(world.state_hash() == hash, "the same bits after a restore");

    world.destroy(box);
    try {
        world.pose(box);
        expect(false, "a stale handle throws");
    } catch (const longspan::Error &error) {
        expect(error.code() == LS_ERROR_STALE_HANDLE, "its code says that the body is gone");
        std::printf("%s\n", error.what());
    }
    longspan::World other = std::move(world);
    expect(world.get().id == 0 && other.time() > 1.9, "the new owner has the world");
    return failures == 0 ? 0 : 1;
}
