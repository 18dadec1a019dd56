/* A ball falls for a second: enough to know that header and library belong together. */
#include <stdio.h>

#include <longspan/longspan.h>

int main(void)
{
    LsWorldDef world_def;
    LsShapeDef shape;
    LsBodyDef def;
    LsWorld world;
    LsBody ball;
    LsPose pose;
    LsVersion version;
    int step;

    if (ls_version_get(&version) != LS_OK || version.abi != LS_ABI_VERSION) {
        return 2;
    }
    ls_world_def_init(&world_def, sizeof world_def);
    ls_shape_def_init(&shape, sizeof shape);
    ls_body_def_init(&def, sizeof def);
    def.shapes = &shape;
    def.shape_count = 1;
    if (ls_world_create(&world_def, &world) != LS_OK || ls_body_create(world, &def, &ball) != LS_OK) {
        fprintf(stderr, "%s\n", ls_last_error_message_get());
        return 1;
    }
    for (step = 0; step < 60; ++step) {
        ls_world_step(world, 1.0f / 60.0f);
    }
    ls_body_pose_get(world, ball, &pose);
    printf("longspan %u.%u.%u: after 1 s the ball is at %.2f m\n", version.major, version.minor, version.patch, pose.position[1]);
    ls_world_destroy(world);
    return pose.position[1] < -4.8 && pose.position[1] > -5.1 ? 0 : 1;
}
