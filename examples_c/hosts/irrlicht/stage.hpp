// The border between the engine and longspan: where bodies and nodes are made together, and numbers change hands.
//
// Irrlicht is left-handed with y up: z is turned round here, and nowhere else.
#ifndef STAGE_HPP
#define STAGE_HPP

#include <irrlicht/irrlicht.h>

#include <cstdint>

#include "longspan/longspan.hpp"

using irr::core::vector3df;
using irr::video::SColor;

inline vector3df to_engine(const double (&p)[3]) {
    return vector3df(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(-p[2]));
}

template <typename Number>
void from_engine(const vector3df &v, Number (&out)[3]) {
    out[0] = v.X;
    out[1] = v.Y;
    out[2] = -v.Z;
}

inline void place(irr::scene::ISceneNode *node, const LsPose &pose) {
    node->setPosition(to_engine(pose.position));
    // Mirrored in z, a rotation keeps its axis' z and its angle, and turns the rest of the axis round.
    irr::core::quaternion turn(-pose.rotation[0], -pose.rotation[1], pose.rotation[2], pose.rotation[3]);
    // Irrlicht's quaternions turn the other way than its Euler angles.
    turn.makeInverse();
    node->setRotation(turn.getMatrix().getRotationDegrees());
}

/// Colours a node, darker below and behind: shading of its own looks the same with every driver of the engine.
inline void paint(irr::scene::IMeshSceneNode *node, SColor color) {
    irr::scene::IMesh *mesh = node->getMesh();
    for (irr::u32 part = 0; part < mesh->getMeshBufferCount(); ++part) {
        irr::scene::IMeshBuffer *buffer = mesh->getMeshBuffer(part);
        auto *vertices = static_cast<irr::video::S3DVertex *>(buffer->getVertices());
        for (irr::u32 i = 0; i < buffer->getVertexCount(); ++i) {
            const vector3df &normal = vertices[i].Normal;
            const float light = 0.7f + 0.2f * normal.Y - 0.1f * normal.Z;
            vertices[i].Color.set(255, static_cast<irr::u32>(color.getRed() * light), static_cast<irr::u32>(color.getGreen() * light),
                                  static_cast<irr::u32>(color.getBlue() * light));
        }
        buffer->setDirty();
    }
    node->getMaterial(0).Lighting = false;
}

/// Where something is in the world (m), z towards the eye.
struct At {
    double x, y, z;
};

/// Makes a node of the engine's for every body; the body's user word is the node.
class Stage {
public:
    Stage(irr::scene::ISceneManager *scene, longspan::World &world) : scene_(scene), world_(world) {}

    longspan::World &world() const { return world_; }

    /// A box of these half extents (m); of its own mass (kg), or of its volume's.
    LsBody box(int kind, At at, vector3df half, SColor color, float mass = 0.0f) {
        longspan::ShapeDef shape(LS_SHAPE_BOX);
        shape.half_extents[0] = half.X;
        shape.half_extents[1] = half.Y;
        shape.half_extents[2] = half.Z;
        shape.material.friction = 0.6f;
        auto *node = scene_->addCubeSceneNode(1.0f);
        node->setScale(half * 2.0f);
        return add(kind, at, shape, node, color, mass);
    }

    LsBody ball(int kind, At at, float radius, SColor color, float mass = 0.0f) {
        longspan::ShapeDef shape(LS_SHAPE_BALL);
        shape.radius = radius;
        return add(kind, at, shape, scene_->addSphereSceneNode(radius), color, mass);
    }

    irr::scene::IMeshSceneNode *node_of(LsBody body) const {
        std::uint64_t word = 0;
        longspan::check(ls_body_user_word_get(world_.get(), body, &word));
        return node_of_word(word);
    }

    static irr::scene::IMeshSceneNode *node_of_word(std::uint64_t word) {
        return reinterpret_cast<irr::scene::IMeshSceneNode *>(static_cast<std::uintptr_t>(word));
    }

private:
    LsBody add(int kind, At at, const LsShapeDef &shape, irr::scene::IMeshSceneNode *node, SColor color, float mass) {
        longspan::BodyDef def(kind);
        def.at(at.x, at.y, at.z).with(shape);
        if (mass > 0.0f) {
            def.mass.kind = LS_MASS_TOTAL;
            def.mass.properties.mass = mass;
        }
        def.user_word = reinterpret_cast<std::uintptr_t>(node);
        paint(node, color);
        node->setPosition(to_engine(def.pose.position));
        return world_.create_body(def);
    }

    irr::scene::ISceneManager *scene_;
    longspan::World &world_;
};

#endif
