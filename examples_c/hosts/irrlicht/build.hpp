// What stands on the stage: a bridge, a crane, a tower, a wall that breaks.
#ifndef BUILD_HPP
#define BUILD_HPP

#include <vector>

#include "stage.hpp"

namespace look {
const SColor ground(255, 90, 110, 85), wood(255, 170, 100, 40), yellow(255, 240, 200, 30), rope(255, 40, 40, 45),
    iron(255, 50, 80, 220), stone(255, 150, 70, 170), brick(255, 215, 60, 45), cart(255, 40, 190, 190), picked(255, 245, 245, 245);
}

/// Planks between two piers, hinged one to the next.
inline std::vector<LsBody> build_bridge(Stage &stage) {
    constexpr int count = 16;
    constexpr float half = 0.25f;
    constexpr double left = -11.0, height = 2.4, right = left + 2.0 * half * count;
    const LsBody pier = stage.box(LS_BODY_STATIC, {left - 0.5, height / 2, 0}, vector3df(0.5f, 1.2f, 1), look::ground);
    const LsBody other = stage.box(LS_BODY_STATIC, {right + 0.5, height / 2, 0}, vector3df(0.5f, 1.2f, 1), look::ground);
    std::vector<LsBody> planks;
    LsBody last = pier;
    for (int i = 0; i <= count; ++i) {
        const bool is_plank = i < count;
        const LsBody next = is_plank ? stage.box(LS_BODY_DYNAMIC, {left + half * (2 * i + 1), height - 0.1, 0},
                                                 vector3df(half, 0.07f, 0.9f), look::wood, 15)
                                     : other;
        longspan::JointDef hinge(LS_JOINT_HINGE, last, next);
        hinge.at(i == 0 ? 0.5 : half, i == 0 ? height / 2 - 0.1 : 0, 0, is_plank ? -half : -0.5, is_plank ? 0 : height / 2 - 0.1, 0);
        // A hinge turns about the x axis of its frames: laid along z.
        for (LsPose *frame : {&hinge.frame_a, &hinge.frame_b}) {
            frame->rotation[1] = -0.70710678f;
            frame->rotation[3] = 0.70710678f;
        }
        stage.world().create_joint(hinge);
        if (is_plank) {
            planks.push_back(next);
        }
        last = next;
    }
    return planks;
}

/// A jib on a mast, turned by a motor, and two tonnes on a rope of links of one kilogram.
struct Crane {
    LsJoint slew;
    LsBody ball;
    double reach; /* from the jib's tip to the middle of the ball (m) */
    double tip;   /* of the jib, from its middle (m) */
    LsBody jib;
};

inline Crane build_crane(Stage &stage) {
    constexpr int links = 10;
    constexpr float half = 0.2f, radius = 0.5f;
    constexpr double x = -2.0, z = -3.0, height = 8.0, length = 2.5;
    const LsBody mast = stage.box(LS_BODY_STATIC, {x, height / 2 - 0.1, z}, vector3df(0.25f, height / 2 - 0.1f, 0.25f), look::yellow);
    const LsBody jib = stage.box(LS_BODY_DYNAMIC, {x + 1.5, height, z}, vector3df(2.5f, 0.18f, 0.18f), look::yellow, 3000);
    longspan::JointDef slew(LS_JOINT_HINGE, mast, jib);
    slew.at(0, height / 2 + 0.1, 0, -1.5, 0, 0);
    for (LsPose *frame : {&slew.frame_a, &slew.frame_b}) {
        frame->rotation[2] = frame->rotation[3] = 0.70710678f;
    }
    slew.motor.mode = LS_MOTOR_VELOCITY;
    slew.motor.max_force = 2e5f;
    Crane crane = {stage.world().create_joint(slew), {0}, 2.0 * half * links + radius, length, jib};
    LsBody last = jib;
    for (int i = 0; i <= links; ++i) {
        const bool is_ball = i == links;
        const double top = height - 2.0 * half * i, below = is_ball ? radius : half;
        const At at = {x + 1.5 + length, top - below, z};
        const LsBody next = is_ball ? stage.ball(LS_BODY_DYNAMIC, at, radius, look::iron, 2000)
                                    : stage.box(LS_BODY_DYNAMIC, at, vector3df(0.05f, half, 0.05f), look::rope, 1);
        longspan::JointDef joint(LS_JOINT_SPHERICAL, last, next);
        joint.at(i == 0 ? length : 0, i == 0 ? 0 : -half, 0, 0, below, 0);
        stage.world().create_joint(joint);
        last = next;
    }
    crane.ball = last;
    return crane;
}

/// Blocks in threes, crosswise; the last one is the topmost in the middle.
inline std::vector<LsBody> build_tower(Stage &stage) {
    std::vector<LsBody> blocks;
    for (int level = 0; level < 10; ++level) {
        for (int side : {-1, 1, 0}) {
            const bool crosswise = level % 2 == 1;
            const double off = 0.5 * side, y = 0.2 + 0.4 * level;
            const vector3df half = crosswise ? vector3df(0.75f, 0.2f, 0.24f) : vector3df(0.24f, 0.2f, 0.75f);
            blocks.push_back(stage.box(LS_BODY_DYNAMIC, {9.0 + (crosswise ? 0 : off), y, crosswise ? off : 0}, half, look::stone));
        }
    }
    return blocks;
}

/// Bricks in mortar that bears so much and no more: joints with a strength, of which the library takes out what breaks.
inline std::vector<LsBody> build_wall(Stage &stage) {
    constexpr int columns = 8, rows = 6;
    const vector3df half(0.3f, 0.25f, 0.25f);
    std::vector<LsBody> bricks;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const At at = {2.0 + 2 * half.X * column, half.Y * (1 + 2 * row), 3};
            bricks.push_back(stage.box(LS_BODY_DYNAMIC, at, half, look::brick));
            longspan::JointDef mortar(LS_JOINT_FIXED, LsBody{0}, bricks.back());
            mortar.strength.tension = mortar.strength.shear = 9000.0f;
            mortar.strength.bending = mortar.strength.torsion = 3000.0f;
            if (column > 0) {
                mortar.body_a = bricks[bricks.size() - 2];
                stage.world().create_joint(mortar.at(half.X, 0, 0, -half.X, 0, 0));
            }
            if (row > 0) {
                mortar.body_a = bricks[bricks.size() - 1 - columns];
                stage.world().create_joint(mortar.at(0, half.Y, 0, 0, -half.Y, 0));
            }
        }
    }
    return bricks;
}

#endif
