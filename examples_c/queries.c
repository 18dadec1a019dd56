/* Questions to a world: what does a ray meet, what would a swept ball meet, what is in a region, what is nearest?
 *
 *     cc queries.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o queries && ./queries */
#include "sample.h"

#include <math.h>

#define BOXES 10

/* Counts how often it is asked, and accepts every other shape. */
static uint32_t every_other(LsShape shape, void *user)
{
    (void)shape;
    return (uint32_t)(++*(int *)user % 2);
}

int main(void)
{
    LsWorld world = create_world();
    LsBody row[BOXES], hit_body;
    LsRay ray = {{-10, 0, 0}, {1, 0, 0}, 100}, rays[2];
    LsRayHit hit, hits[BOXES];
    LsQueryFilter filter;
    LsShapeDef ball, plank, held;
    LsCastDef cast;
    LsCastHit met;
    LsShapeDistance gap;
    LsPose pose = {{-10, 0.9, 0}, {0, 0, 0, 1}};
    LsNearestPoint nearest;
    LsShape shapes[BOXES];
    const float path[3] = {50, 0, 0};
    const double point[3] = {0, 2, 0}, min[3] = {3.9, -1, -1}, max[3] = {8.1, 1, 1};
    size_t count, i;
    int asked = 0;

    for (i = 0; i < BOXES; ++i) {
        row[i] = create_body(world, i == 0 ? LS_BODY_STATIC : LS_BODY_DYNAMIC, LS_SHAPE_BOX, 2.0 * (double)i, 0.0);
    }

    check(ls_world_ray_cast(world, &ray, NULL, &hit));
    printf("the ray meets its first box after %.2f m, at x = %.2f m\n", hit.distance, hit.point[0]);
    expect(hit.body.id == row[0].id && fabsf(hit.distance - 9.5f) < 1e-4f && hit.normal[0] == -1.0f, "it is the first of the row");

    check(ls_query_filter_init(&filter, sizeof filter));
    filter.kinds = LS_QUERY_DYNAMIC;
    filter.ignored = &row[1];
    filter.ignored_count = 1;
    check(ls_world_ray_cast(world, &ray, &filter, &hit));
    expect(hit.body.id == row[2].id, "without static bodies and the second box it is the third");

    check(ls_world_ray_cast_all(world, &ray, NULL, hits, BOXES, &count));
    expect(count == BOXES && hits[9].body.id == row[9].id, "all boxes, in order");
    expect(ls_world_ray_cast_all(world, &ray, NULL, hits, 3, &count) == LS_ERROR_BUFFER_TOO_SMALL && count == BOXES,
           "a buffer too small is told the number");

    check(ls_query_filter_init(&filter, sizeof filter));
    filter.accept = every_other;
    filter.user = &asked;
    check(ls_world_ray_cast_all(world, &ray, &filter, hits, BOXES, &count));
    printf("asked about %d shapes, the host accepted %u\n", asked, (unsigned)count);
    expect(asked == BOXES && count == BOXES / 2, "the host has the last word");

    check(ls_shape_def_init(&ball, sizeof ball));
    check(ls_world_shape_cast(world, &ball, &pose, path, NULL, &hit));
    expect(hit.body.id == row[0].id && hit.distance > 9.0f && hit.distance < 9.5f && hit.normal[1] > 0.1f,
           "a ball of 0.5 m touches an upper edge");
    check(ls_world_shape_cast_all(world, &ball, &pose, path, NULL, hits, BOXES, &count));
    expect(count == BOXES, "going on, it would touch them all");

    pose.position[0] = 1.0;
    pose.position[1] = 0.0;
    ball.radius = 0.6f;
    check(ls_world_shape_overlaps_get(world, &ball, &pose, NULL, shapes, BOXES, &count));
    expect(count == 2, "a ball between two boxes overlaps both");
    check(ls_world_box_overlaps_get(world, min, max, NULL, shapes, BOXES, &count));
    expect(count == 3, "three boxes are in the region");

    check(ls_world_nearest_point_get(world, point, 10.0f, NULL, &nearest));
    check(ls_shape_body_get(world, nearest.shape, &hit_body));
    printf("the nearest box is %.2f m away\n", nearest.distance);
    expect(hit_body.id == row[0].id && nearest.point[1] == 0.5, "the nearest point is on top of the first box");
    check(ls_world_nearest_point_get(world, point, 1.0f, NULL, &nearest));
    expect(nearest.shape.id == 0, "nothing is within 1 m");

    /* A plank 2 m long, held at one end above the row, is swung down by a quarter turn: the other end meets the third box. */
    check(ls_cast_def_init(&cast, sizeof cast));
    check(ls_shape_def_init(&plank, sizeof plank));
    plank.kind = LS_SHAPE_BOX;
    plank.half_extents[0] = 1.0f;
    plank.half_extents[1] = plank.half_extents[2] = 0.05f;
    plank.local_position[0] = 1.0f;
    check(ls_shape_def_init(&held, sizeof held));
    held.kind = LS_SHAPE_COMPOUND;
    held.parts = &plank;
    held.part_count = 1;
    cast.shape = &held;
    cast.pose.position[0] = 2.0;
    cast.pose.position[1] = 1.5;
    cast.turn[2] = -1.5707964f;
    check(ls_world_cast(world, &cast, NULL, &met));
    printf("swung down, the plank is stopped after %.0f degrees\n", 90.0 * met.fraction);
    expect(met.body.id == row[2].id && met.fraction > 0.2 && met.fraction < 0.5 && met.part == LS_NO_INDEX, "a box is in its way");

    check(ls_world_nearest_shape_get(world, &ball, &pose, 1.0f, NULL, &gap));
    expect(gap.distance < 0.0 && fabs(gap.distance + 0.1) < 1e-6, "the ball between two boxes overlaps one by 0.1 m");

    rays[0] = rays[1] = ray;
    rays[1].direction[0] = -1.0f;
    check(ls_world_rays_cast(world, rays, 2, NULL, hits));
    expect(hits[0].body.id == row[0].id && hits[1].shape.id == 0, "one ray of two meets something");
    check(ls_world_destroy(world));
    return 0;
}
