// longspan beside an engine: Irrlicht owns the scene, the camera and what its own animators move; longspan owns a
// bridge, a crane, a tower and a wall.
//
//     engine -> longspan   a node that Irrlicht's animator moves is a kinematic body: it pushes what it meets; what a pixel shows
//                          is found by the ray that the engine's camera gives
//     longspan -> engine   what moved is copied to nodes, found by the body's user word; bricks of broken mortar change colour
//
//     ./irrlicht FILE.ppm    plays ten seconds, saves the last frame, prints what became of everything
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "build.hpp"

namespace {

constexpr float step = 1.0f / 60.0f;
constexpr int frames = 600;

/// A hand that takes hold of what a pixel shows, and lifts it.
class Hand {
public:
    explicit Hand(Stage &stage) : stage_(stage), body_(stage.world().create_body(longspan::BodyDef(LS_BODY_KINEMATIC))) {}

    /// Whether there is something to take hold of on this line of sight.
    bool grab(const irr::core::line3df &sight) {
        LsRay ray = {};
        from_engine(sight.start, ray.origin);
        from_engine(sight.getVector().normalize(), ray.direction);
        ray.length = static_cast<float>(sight.getLength());
        longspan::QueryFilter filter;
        filter.kinds = LS_QUERY_DYNAMIC;
        const LsRayHit hit = stage_.world().cast_ray(ray, &filter);
        if (hit.shape.id == 0) {
            return false;
        }
        held_ = hit.body;
        at_ = stage_.world().pose(held_);
        stage_.world().set_pose(body_, at_);
        longspan::JointDef grip(LS_JOINT_FIXED, body_, held_);
        grip.linear.compliance = 1e-5f;
        grip.linear.damping = 2000.0f;
        stage_.world().create_joint(grip);
        paint(stage_.node_of(held_), look::picked);
        return true;
    }

    void lift(double up, double aside) {
        if (held_.id != 0) {
            at_.position[0] += aside;
            at_.position[1] += up;
            longspan::check(ls_body_move_to(stage_.world().get(), body_, &at_));
        }
    }

    LsBody held() const { return held_; }

private:
    Stage &stage_;
    LsBody body_, held_ = {0};
    LsPose at_ = {};
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
            const SColor color = image->getPixel(x, y);
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
    IrrlichtDevice *device = createDevice(video::EDT_BURNINGSVIDEO, core::dimension2du(960, 540));
    if (device == nullptr) {
        std::fprintf(stderr, "Irrlicht opens no window\n");
        return 1;
    }
    video::IVideoDriver *driver = device->getVideoDriver();
    scene::ISceneManager *scene = device->getSceneManager();
    scene::ICameraSceneNode *camera = scene->addCameraSceneNode(nullptr, vector3df(0.5f, 5.5f, -14), vector3df(-0.3f, 3.2f, 0));

    longspan::World world;
    Stage stage(scene, world);
    stage.box(LS_BODY_STATIC, {0, -0.5, 0}, vector3df(20, 0.5f, 20), look::ground);
    const std::vector<LsBody> planks = build_bridge(stage), tower = build_tower(stage);
    const Crane crane = build_crane(stage);
    build_wall(stage);
    Hand hand(stage);
    // A cart that the engine's own animator moves; in the world it is a kinematic body.
    const LsBody cart = stage.box(LS_BODY_KINEMATIC, {-11, 0.5, 4}, vector3df(0.8f, 0.5f, 0.8f), look::cart);
    const LsBody parcel = stage.box(LS_BODY_DYNAMIC, {-7, 0.3, 4}, vector3df(0.3f, 0.3f, 0.3f), look::wood, 20);
    scene::ISceneNode *cart_node = stage.node_of(cart);
    scene::ISceneNodeAnimator *drive =
        scene->createFlyStraightAnimator(vector3df(-11, 0.5f, -4), vector3df(-4, 0.5f, -4), 6000, false, false);

    std::size_t broken = 0;
    for (int frame = 0; frame < frames && device->run(); ++frame) {
        // The engine's clock runs as fast as it can draw; its animators are asked for the time of the world.
        drive->animateNode(cart_node, static_cast<u32>(frame * 1000 / 60));
        LsPose target = {{0, 0, 0}, {0, 0, 0, 1}};
        from_engine(cart_node->getPosition(), target.position);
        longspan::check(ls_body_move_to(world.get(), cart, &target));
        if (frame == 30 || frame == 210) {
            LsJointDef slew;
            longspan::check(ls_joint_def_get(world.get(), crane.slew, &slew, sizeof slew));
            slew.motor.target = frame == 30 ? -0.2f : 0.0f;
            longspan::check(ls_joint_kind_set(world.get(), crane.slew, &slew));
        }
        if (frame == 120) {
            const LsBody shot = stage.ball(LS_BODY_DYNAMIC, {4.4, 2.0, 14}, 0.35f, look::iron, 250);
            const float velocity[3] = {0, -1, -30};
            longspan::check(ls_body_linear_velocity_set(world.get(), shot, velocity));
            longspan::check(ls_body_fast_set(world.get(), shot, 1));
        }
        if (frame == 301) {
            auto *eye = scene->getSceneCollisionManager();
            const core::position2di pixel = eye->getScreenCoordinatesFrom3DPosition(stage.node_of(tower.back())->getPosition(), camera);
            std::printf("picked: %d\n", hand.grab(eye->getRayFromScreenCoordinates(pixel, camera)));
        }
        if (frame > 301 && frame < 480) {
            hand.lift(0.012, -0.005);
        }
        world.step(step);
        for (const LsMoved &moved : world.moved()) {
            if (moved.user_word != 0 && moved.body.id != cart.id) {
                place(Stage::node_of_word(moved.user_word), moved.pose);
            }
        }
        for (const LsJointBreak &joint : world.broken()) {
            ++broken;
            for (const LsBody side : {joint.body_a, joint.body_b}) {
                paint(stage.node_of(side), SColor(255, 250, 150, 60));
            }
        }
        // A software driver draws slowly; only some frames are shown.
        if (frame % 60 == 0 || frame + 1 == frames) {
            driver->beginScene(true, true, SColor(255, 150, 185, 225));
            scene->drawAll();
            driver->endScene();
        }
    }
    double sag = 1e9, stands = 0;
    for (const LsBody plank : planks) {
        sag = std::min(sag, world.pose(plank).position[1]);
    }
    for (const LsBody block : tower) {
        stands = std::max(stands, block.id == hand.held().id ? 0.0 : world.pose(block).position[1]);
    }
    const LsPose ball = world.pose(crane.ball), jib = world.pose(crane.jib);
    // Along the jib: the x axis of its rotation, which is one about y.
    const double turn = 2.0 * std::atan2(jib.rotation[1], jib.rotation[3]);
    const double tip[3] = {jib.position[0] + crane.tip * std::cos(turn), jib.position[1], jib.position[2] - crane.tip * std::sin(turn)};
    const double reach = std::hypot(ball.position[0] - tip[0], ball.position[1] - tip[1], ball.position[2] - tip[2]);
    std::printf("bridge: lowest plank at %.3f m\n", sag);
    std::printf("crane: the ball is %.3f m from the jib, of %.3f m\n", reach, crane.reach);
    std::printf("tower: its top is at %.2f m\n", stands);
    std::printf("wall: %u joints broken\n", static_cast<unsigned>(broken));
    std::printf("hand: holds a block at %.2f m\n", hand.held().id != 0 ? world.pose(hand.held()).position[1] : 0.0);
    std::printf("parcel: the engine's cart has pushed it from -7 to %.2f m\n", world.pose(parcel).position[0]);
    const bool saved = save(driver, argv[1]);
    drive->drop();
    device->drop();
    return saved ? 0 : 1;
}
