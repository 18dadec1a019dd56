/* A host with unusual floating-point settings: denormals flushed, rounding upwards, traps on everything, inexact results
 * included. The library must compute what it always computes, and every call must leave the settings as they were. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "longspan/longspan.h"

#if defined(__x86_64__)
#include <xmmintrin.h>
static unsigned get_settings(void) { return _mm_getcsr(); }
static void set_settings(unsigned settings) { _mm_setcsr(settings); }
static const unsigned USUAL = 0x1F80u;
static const unsigned UNUSUAL = 0x8000u | 0x4000u | 0x0040u; /* flush to zero, round up, denormals are zero; no mask bit set */
#elif defined(__aarch64__)
static unsigned get_settings(void)
{
    unsigned long settings;
    __asm__ volatile("mrs %0, fpcr" : "=r"(settings));
    return (unsigned)settings;
}
static void set_settings(unsigned settings)
{
    const unsigned long wide = settings;
    __asm__ volatile("msr fpcr, %0" : : "r"(wide));
}
static const unsigned USUAL = 0u;
static const unsigned UNUSUAL = 0x01400000u; /* flush to zero, round up */
#else
static unsigned get_settings(void) { return 0u; }
static void set_settings(unsigned settings) { (void)settings; }
static const unsigned USUAL = 0u, UNUSUAL = 0u;
#endif

static unsigned expected;
static int calls_back = 0;

static void check(LsResult result)
{
    const unsigned found = get_settings();
    set_settings(USUAL);
    if (result != LS_OK) {
        printf("%s: %s\n", ls_result_name_get(result), ls_last_error_message_get());
        exit(1);
    }
    if (found != expected) {
        printf("settings are %#x after a call, not %#x\n", found, expected);
        exit(1);
    }
    set_settings(found);
}

static void on_overload(LsWorld world, const LsJointOverload *overload, void *user)
{
    LsJointState state;
    (void)user;
    check(ls_joint_state_get(world, overload->joint, &state, sizeof state));
    ++calls_back;
}

/* Boxes tumble over each other, one hangs from a joint that is too weak; the hash is of the state after two seconds. All numbers
 * that the host computes are exact, so that it does not trip over its own traps. */
static uint64_t run(unsigned settings, uint32_t threads)
{
    LsWorldDef world_def;
    LsShapeDef shape;
    LsBodyDef def;
    LsJointDef joint_def;
    LsWorld world;
    LsBody body, first = {0};
    LsJoint joint;
    uint64_t hash;
    int i;

    expected = settings;
    set_settings(settings);
    check(ls_world_def_init(&world_def, sizeof world_def));
    world_def.threads = threads;
    check(ls_world_create(&world_def, &world));
    check(ls_world_overload_callback_set(world, on_overload, NULL));

    check(ls_shape_def_init(&shape, sizeof shape));
    check(ls_body_def_init(&def, sizeof def));
    def.shapes = &shape;
    def.shape_count = 1;
    def.kind = LS_BODY_STATIC;
    shape.kind = LS_SHAPE_HALF_SPACE;
    check(ls_body_create(world, &def, &body));

    shape.kind = LS_SHAPE_BOX;
    def.kind = LS_BODY_DYNAMIC;
    def.angular_velocity[0] = 3.0f;
    def.angular_velocity[2] = -1.0e-38f; /* falls below the normal range when it is damped */
    def.angular_damping = 1.0f;
    for (i = 0; i < 12; ++i) {
        def.pose.position[0] = (double)(i % 2) * 0.5;
        def.pose.position[1] = (double)(1 + i);
        check(ls_body_create(world, &def, &body));
        if (i == 0) {
            first = body;
        }
    }
    check(ls_joint_def_init(&joint_def, sizeof joint_def));
    joint_def.kind = LS_JOINT_SPHERICAL;
    joint_def.body_b = first;
    joint_def.frame_a.position[1] = 4.0;
    joint_def.frame_b.position[1] = 3.0;
    joint_def.break_force = 1.0f;
    check(ls_joint_create(world, &joint_def, &joint));

    for (i = 0; i < 120; ++i) {
        check(ls_world_step(world, 1.0f / 60.0f));
    }
    check(ls_world_state_hash_get(world, &hash));
    check(ls_world_destroy(world));
    set_settings(USUAL);
    return hash;
}

int main(void)
{
    const uint64_t usual = run(USUAL, 1), unusual = run(UNUSUAL, 1), threaded = run(UNUSUAL, 2);
    printf("%016llx %016llx %016llx, %d callbacks\n", (unsigned long long)usual, (unsigned long long)unusual,
           (unsigned long long)threaded, calls_back);
    return usual == unusual && usual == threaded && calls_back > 0 ? 0 : 1;
}
