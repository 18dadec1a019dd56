/* Steps of 1/60 s in frames of any length, and poses in between to draw: what every game loop needs.
 *
 *     cc fixed_step.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o fixed_step && ./fixed_step
 *
 * Frames of 1/144 s with a hiccup; prints how uneven the drawn motion of a falling ball is with and without it. */
#include "sample.h"

#include <math.h>

#define DT (1.0f / 60.0f)
#define MAX_STEPS 4 /* more time than that is dropped: a host that cannot keep up must not fall behind for ever */

/* Between two poses: positions linearly, rotations along the shorter arc, near enough for the turn of one step. */
static LsPose between(const LsPose *from, const LsPose *to, float share)
{
    LsPose pose;
    float dot = 0.0f, length = 0.0f;
    int i;
    for (i = 0; i < 3; ++i) {
        pose.position[i] = from->position[i] + (to->position[i] - from->position[i]) * share;
    }
    for (i = 0; i < 4; ++i) {
        dot += from->rotation[i] * to->rotation[i];
    }
    for (i = 0; i < 4; ++i) {
        const float target = dot < 0.0f ? -to->rotation[i] : to->rotation[i];
        pose.rotation[i] = from->rotation[i] + (target - from->rotation[i]) * share;
        length += pose.rotation[i] * pose.rotation[i];
    }
    for (i = 0; i < 4; ++i) {
        pose.rotation[i] /= sqrtf(length);
    }
    return pose;
}

int main(void)
{
    LsWorldDef world_def;
    LsShapeDef shape;
    LsBodyDef def;
    LsWorld world;
    LsBody ball;
    LsPose previous, now, drawn;
    double rest = 0.0, clock = 0.0, uneven = 0.0, uneven_raw = 0.0;
    int frame, steps = 0;

    check(ls_world_def_init(&world_def, sizeof world_def));
    world_def.gravity[1] = 0.0f;
    check(ls_world_create(&world_def, &world));
    check(ls_shape_def_init(&shape, sizeof shape));
    check(ls_body_def_init(&def, sizeof def));
    def.linear_velocity[0] = 6.0f;
    def.angular_velocity[2] = 3.0f;
    def.shapes = &shape;
    def.shape_count = 1;
    check(ls_body_create(world, &def, &ball));
    check(ls_body_pose_get(world, ball, &now));
    previous = now;

    for (frame = 0; frame < 288; ++frame) {
        const double seconds = frame == 100 ? 0.05 : 1.0 / 144.0;
        int due;
        rest += seconds;
        clock += seconds;
        for (due = 0; rest >= DT; rest -= DT) {
            if (++due > MAX_STEPS) {
                continue;
            }
            previous = now;
            check(ls_world_step(world, DT));
            check(ls_body_pose_get(world, ball, &now));
            ++steps;
        }
        drawn = between(&previous, &now, (float)(rest / DT));
        /* What is drawn is one step late, and even; the pose of the last step alone jumps. */
        if (clock > 2.0 * DT) {
            uneven = fmax(uneven, fabs(drawn.position[0] - 6.0 * (clock - DT)));
            uneven_raw = fmax(uneven_raw, fabs(now.position[0] - 6.0 * (clock - 0.5 * DT)));
        }
    }
    printf("%d steps in %d frames; uneven by %.4f m between poses, by %.4f m without\n", steps, frame, uneven, uneven_raw);
    check(ls_world_destroy(world));
    return uneven < 0.002 && uneven_raw > 0.02 ? 0 : 1;
}
