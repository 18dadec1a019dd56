// longspan beside an engine: Irrlicht owns the scene, the camera, the lights and what its own animators move; longspan owns a chain
// with a wrecking ball and a pile of crates.
//
//     engine -> longspan   a node that Irrlicht's animator moves is a kinematic body: it pushes what it meets
//     longspan -> engine   what moved is copied to nodes, found by the body's user word; hits light a crate up
//
// Irrlicht is left-handed with y up: z is turned round at the border, in one place.
//
//     ./irrlicht FILE.ppm    plays eight seconds, saves the last frame, prints what became of everything
#include <irrlicht/irrlicht.h>

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <vector>

#include "longspan/longspan.hpp"

namespace {

using irr::core::vector3df;

constexpr float step = 1.0f / 60.0f;
constexpr int frames = 480;

vector3df to_engine(const double (&p)[3]) {
    return vector3df(static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(-p[2]));
}

void from_engine(const vector3df &v, double (&out)[3]) {
    out[0] = v.X;
    out[1] = v.Y;
    out[2] = -v.Z;
}

void place(irr::scene::ISceneNode *node, const LsPose &pose) {
    node->setPosition(to_engine(pose.position));
    // Mirrored in z, a rotation keeps its axis' z and its angle, and turns the rest of the axis round.
    irr::core::quaternion turn(-pose.rotation[0], -pose.rotation[1], pose.rotation[2], pose.rotation[3]);
    // Irrlicht's quaternions turn the other way than its Euler angles.
    turn.makeInverse();
    irr::core::matrix4 matrix = turn.getMatrix();
    node->setRotation(matrix.getRotationDegrees());
}

class Stage {
public:
    Stage(irr::scene::ISceneManager *scene, longspan::World &world) : scene_(scene), world_(world) {}

    LsBody box(int kind, double x, double y, double z, vector3df half, irr::video::SColor color, float mass = 0.0f) {
        longspan::ShapeDef shape(LS_SHAPE_BOX);
        shape.half_extents[0] = half.X;
        shape.half_extents[1] = half.Y;
        shape.half_extents[2] = half.Z;
        auto *node = scene_->addCubeSceneNode(1.0f);
        node->setScale(half * 2.0f);
        return add(kind, x, y, z, shape, node, color, mass);
    }

    LsBody ball(int kind, double x, double y, double z, float radius, irr::video::SColor color, float mass = 0.0f) {
        longspan::ShapeDef shape(LS_SHAPE_BALL);
        shape.radius = radius;
        return add(kind, x, y, z, shape, scene_->addSphereSceneNode(radius), color, mass);
    }

    irr::scene::ISceneNode *node_of(LsBody body) const {
        std::uint64_t word = 0;
        longspan::check(ls_body_user_word_get(world_.get(), body, &word));
        return reinterpret_cast<irr::scene::ISceneNode *>(static_cast<std::uintptr_t>(word));
    }

    static void paint(irr::scene::ISceneNode *node, irr::video::SColor color) {
        auto &material = node->getMaterial(0);
        material.AmbientColor = material.DiffuseColor = color;
        material.EmissiveColor.set(0);
        material.NormalizeNormals = true;
    }

private:
    LsBody add(int kind, double x, double y, double z, const LsShapeDef &shape, irr::scene::ISceneNode *node, irr::video::SColor color,
               float mass) {
        longspan::BodyDef def(kind);
        def.at(x, y, z).with(shape);
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

bool save(irr::video::IVideoDriver *driver, const char *path) {
    irr::video::IImage *image = driver->createScreenShot();
    if (image == nullptr) {
        return false;
    }
    const auto size = image->getDimension();
    std::vector<char> pixels;
    for (irr::u32 y = 0; y < size.Height; ++y) {
        for (irr::u32 x = 0; x < size.Width; ++x) {
            const irr::video::SColor color = image->getPixel(x, y);
            pixels.push_back(static_cast<char>(color.getRed()));
            pixels.push_back(static_cast<char>(color.getGreen()));
            pixels.push_back(static_cast<char>(color.getBlue()));
        }
    }
    image->drop();
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << size.Width << ' ' << size.Height << "\n255\n";
    file.write(pixels.data(), static_cast<std::streamsize>(pixels.size()));
    return file.good();
}

}  // namespace

int main(int argc, char **argv) {
    using namespace irr;
    if (argc != 2) {
        std::fprintf(stderr, "usage: irrlicht FILE.ppm\n");
        return 2;
    }
    IrrlichtDevice *device = createDevice(video::EDT_BURNINGSVIDEO, core::dimension2du(800, 480));
    if (device == nullptr) {
        std::fprintf(stderr, "Irrlicht opens no window\n");
        return 1;
    }
    video::IVideoDriver *driver = device->getVideoDriver();
    scene::ISceneManager *scene = device->getSceneManager();
    scene->addCameraSceneNode(nullptr, vector3df(3, 5, -16), vector3df(0, 3, 0));
    scene->setAmbientLight(video::SColorf(0.6f, 0.6f, 0.6f));
    scene->addLightSceneNode(nullptr, vector3df(6, 14, -14), video::SColorf(0.7f, 0.7f, 0.7f), 60.0f);

    const video::SColor ground(255, 90, 110, 85), steel(255, 40, 40, 45), iron(255, 50, 80, 220), wood(255, 170, 100, 40),
        bright(255, 240, 40, 40), cart_color(255, 240, 200, 30);
    longspan::World world;
    longspan::check(ls_world_hit_threshold_set(world.get(), 1.5f));
    Stage stage(scene, world);
    stage.box(LS_BODY_STATIC, 0, -0.5, 0, vector3df(20, 0.5f, 20), ground);

    // Two tonnes on links of a kilogram, let go from the side.
    LsBody last = stage.box(LS_BODY_STATIC, 0, 8, 0, vector3df(1, 0.15f, 0.15f), steel);
    constexpr int links = 10;
    constexpr float half = 0.3f;
    for (int i = 0; i <= links; ++i) {
        const bool is_ball = i == links;
        const LsBody next = is_ball ? stage.ball(LS_BODY_DYNAMIC, -2 * half * i - 0.6, 8, 0, 0.6f, iron, 2000)
                                    : stage.box(LS_BODY_DYNAMIC, -2 * half * (i + 0.5), 8, 0, vector3df(half, 0.06f, 0.06f), steel, 1);
        longspan::JointDef joint(LS_JOINT_SPHERICAL, last, next);
        joint.at(i == 0 ? 0 : -half, 0, 0, is_ball ? 0.6 : half, 0, 0);
        world.create_joint(joint);
        last = next;
    }
    const LsBody ball = last;
    std::vector<LsBody> crates;
    for (int row = 0; row < 5; ++row) {
        for (int column = 0; column < 3; ++column) {
            crates.push_back(
                stage.box(LS_BODY_DYNAMIC, 1.2 + column * 0.82, 0.4 + row * 0.8, 0, vector3df(0.4f, 0.4f, 0.4f), wood, 60));
        }
    }
    // A cart that the engine's own animator moves; in the world it is a kinematic body.
    const LsBody cart = stage.box(LS_BODY_KINEMATIC, -9, 0.5, 2, vector3df(0.8f, 0.5f, 0.8f), cart_color);
    scene::ISceneNode *cart_node = stage.node_of(cart);
    const LsBody parcel = stage.box(LS_BODY_DYNAMIC, -3, 0.3, 2, vector3df(0.3f, 0.3f, 0.3f), wood, 20);
    scene::ISceneNodeAnimator *drive =
        scene->createFlyStraightAnimator(vector3df(-9, 0.5f, -2), vector3df(4, 0.5f, -2), 7000, false, false);

    int hits = 0;
    for (int frame = 0; frame < frames && device->run(); ++frame) {
        // The engine's clock runs as fast as it can draw; its animators are asked for the time of the world.
        drive->animateNode(cart_node, static_cast<u32>(frame * 1000 / 60));
        LsPose target = {{0, 0, 0}, {0, 0, 0, 1}};
        from_engine(cart_node->getPosition(), target.position);
        longspan::check(ls_body_move_to(world.get(), cart, &target));
        world.step(step);
        for (const LsMoved &moved : world.moved()) {
            if (moved.body.id != cart.id) {
                place(reinterpret_cast<scene::ISceneNode *>(static_cast<std::uintptr_t>(moved.user_word)), moved.pose);
            }
        }
        const LsHit *list = nullptr;
        std::size_t count = 0;
        longspan::check(ls_world_hits(world.get(), &list, &count));
        for (const LsHit &hit : longspan::Span<LsHit>(list, count)) {
            ++hits;
            for (const LsBody body : {hit.pair.body_a, hit.pair.body_b}) {
                for (const LsBody crate : crates) {
                    if (crate.id == body.id && hit.impulse > 200.0f) {
                        Stage::paint(stage.node_of(crate), bright);
                    }
                }
            }
        }
        // A software driver draws slowly; only some frames are shown.
        if (frame % 60 == 0 || frame + 1 == frames) {
            driver->beginScene(true, true, video::SColor(255, 150, 185, 225));
            scene->drawAll();
            driver->endScene();
        }
    }
    const LsPose hangs = world.pose(ball), pushed = world.pose(parcel);
    const double reach = std::hypot(hangs.position[0], hangs.position[1] - 8.0, hangs.position[2]);
    std::printf("chain: the ball is %.3f m from its hook, of 6.600 m at rest\n", reach);
    std::printf("crates: %d hits\n", hits);
    std::printf("parcel: the engine's cart has pushed it from -3 to %.2f m\n", pushed.position[0]);
    const bool saved = save(driver, argv[1]);
    drive->drop();
    device->drop();
    return saved ? 0 : 1;
}
