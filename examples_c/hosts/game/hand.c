#include <math.h>

#include "game.h"

/* A spring that a tonne follows without jerks. */
static const float GRIP_COMPLIANCE = 5e-5f, GRIP_DAMPING = 4000.0f;

static void point_at(const LsRay *ray, double distance, double out[3])
{
    int i;
    for (i = 0; i < 3; ++i) {
        out[i] = ray->origin[i] + ray->direction[i] * distance;
    }
}

int hand_grab(Game *game, const Camera *camera, int x, int y)
{
    LsRay ray = camera_ray(camera, x, y);
    LsQueryFilter filter;
    LsRayHit hit;
    LsPose at = {{0, 0, 0}, {0, 0, 0, 1}}, pose;
    LsJointDef def;
    float inverse[3], offset[3];
    int i;
    hand_release(game);
    check(ls_query_filter_init(&filter, sizeof filter));
    filter.kinds = LS_QUERY_DYNAMIC;
    check(ls_world_ray_cast(game->world, &ray, &filter, &hit));
    if (hit.shape.id == 0) {
        return 0;
    }
    game->reach = hit.distance;
    point_at(&ray, game->reach, at.position);
    check(ls_body_pose_set(game->world, game->hand, &at));
    check(ls_body_pose_get(game->world, hit.body, &pose));
    /* The point in the body's own frame: back along its rotation, q* v q. */
    for (i = 0; i < 3; ++i) {
        offset[i] = (float)(hit.point[i] - pose.position[i]);
        inverse[i] = -pose.rotation[i];
    }
    check(ls_joint_def_init(&def, sizeof def));
    def.kind = LS_JOINT_SPHERICAL;
    def.body_a = game->hand;
    def.body_b = hit.body;
    for (i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const float w = pose.rotation[3];
        const float dot = inverse[0] * offset[0] + inverse[1] * offset[1] + inverse[2] * offset[2];
        const float length = inverse[0] * inverse[0] + inverse[1] * inverse[1] + inverse[2] * inverse[2];
        const float cross = inverse[j] * offset[k] - inverse[k] * offset[j];
        def.frame_b.position[i] = 2.0f * dot * inverse[i] + (w * w - length) * offset[i] + 2.0f * w * cross;
    }
    def.linear.compliance = GRIP_COMPLIANCE;
    def.linear.damping = GRIP_DAMPING;
    check(ls_joint_create(game->world, &def, &game->grip));
    return 1;
}

void hand_move(Game *game, const Camera *camera, int x, int y)
{
    LsRay ray = camera_ray(camera, x, y);
    LsPose at = {{0, 0, 0}, {0, 0, 0, 1}};
    if (game->grip.id != 0) {
        point_at(&ray, game->reach, at.position);
        check(ls_body_move_to(game->world, game->hand, &at));
    }
}

void hand_release(Game *game)
{
    if (game->grip.id != 0) {
        /* It may be gone with what it held. */
        ls_joint_destroy(game->world, game->grip);
        game->grip.id = 0;
    }
}
