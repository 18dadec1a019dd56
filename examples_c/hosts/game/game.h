/* A small game in plain C: SDL for the window, OpenGL for the picture, longspan for everything that moves.
 *
 *     scene.c    what there is: ground, bridge, crane, tower, wall
 *     hand.c     picking things up with the mouse
 *     view.c     camera, drawing, pictures
 *     main.c     the window, the loop, the keys */
#ifndef GAME_H
#define GAME_H

#include <stddef.h>
#include <stdint.h>

#include "longspan/longspan.h"

#define STEP (1.0f / 60.0f)
#define MAX_THINGS 1024

/* What a thing is drawn as: the colours are far enough apart to be told from a picture. */
typedef enum Look { LOOK_GROUND, LOOK_BRIDGE, LOOK_CRANE, LOOK_ROPE, LOOK_BALL, LOOK_TOWER, LOOK_WALL, LOOK_COUNT } Look;

/* A body as the game knows it; its user word is its place in the list, plus one. */
typedef struct Thing {
    LsBody body;
    Look look;
    int is_ball;
    float half[3]; /* half extents, or the radius (m) */
    LsPose before, now;
} Thing;

typedef struct Game {
    LsWorld world;
    Thing things[MAX_THINGS];
    size_t count;
    LsJoint slew; /* turns the crane's jib */
    float slew_speed;
    int bricks_broken;
    void *start; /* snapshot of the beginning */
    size_t start_size, start_count;

    LsBody hand; /* moves with the mouse */
    LsJoint grip;
    double reach; /* distance at which the hand is (m) */
} Game;

/* Where the eye is, and what it looks at. */
typedef struct Camera {
    double eye[3], target[3];
    float field; /* angle from bottom to top (rad) */
    int width, height;
} Camera;

/* Ends the program if a call has failed. */
void check(LsResult result);

void scene_build(Game *game);
void scene_step(Game *game);
void scene_reset(Game *game);
void scene_shoot(Game *game, const double from[3], const double towards[3], float speed);

/* The ray of a pixel, and the pixel of a point. */
LsRay camera_ray(const Camera *camera, int x, int y);
void camera_pixel(const Camera *camera, const double point[3], int *x, int *y);

int hand_grab(Game *game, const Camera *camera, int x, int y);
void hand_move(Game *game, const Camera *camera, int x, int y);
void hand_release(Game *game);

void view_draw(const Game *game, const Camera *camera, float share, int debug);
int view_save(const char *path, int width, int height);

#endif
