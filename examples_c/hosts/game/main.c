/* ./game                       play: drag with the left button, space shoots, left and right turn the crane, D shows what the
 *                              library sees, R begins again, Escape ends
 * ./game --picture FILE.ppm    plays a script of ten seconds without looking at the clock, saves the last frame, prints what
 *                              became of everything */
#include <SDL2/SDL.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "game.h"

#define WIDTH 960
#define HEIGHT 540

static const double WALL[3] = {4.4, 1.6, 4.0}, GUN[3] = {4.4, 2.5, 16.0};

static Thing *top_of_tower(Game *game)
{
    Thing *top = NULL;
    size_t i;
    for (i = 0; i < game->count; ++i) {
        Thing *thing = &game->things[i];
        if (thing->look == LOOK_TOWER && (top == NULL || thing->now.position[1] > top->now.position[1])) {
            top = thing;
        }
    }
    return top;
}

/* What a player would do, by frame. */
static void play_script(Game *game, const Camera *camera, int frame)
{
    static int x, y;
    if (frame == 30) {
        game->slew_speed = -0.25f;
    }
    if (frame == 120) {
        scene_shoot(game, GUN, WALL, 30.0f);
    }
    if (frame == 240) {
        game->slew_speed = 0.0f;
    }
    if (frame == 300) {
        camera_pixel(camera, top_of_tower(game)->now.position, &x, &y);
        printf("grabbed: %d\n", hand_grab(game, camera, x, y));
    }
    if (frame > 300 && frame < 420) {
        hand_move(game, camera, x + (frame - 300), y - (frame - 300) / 2);
    }
    if (frame == 480) {
        hand_release(game);
    }
}

static void print_outcome(Game *game)
{
    double sag = 1e9, length = 0.0;
    const Thing *top = NULL, *ball = NULL;
    size_t i;
    int k;
    for (i = 0; i < game->count; ++i) {
        const Thing *thing = &game->things[i];
        const double y = thing->now.position[1];
        if (thing->look == LOOK_BRIDGE) {
            sag = fmin(sag, y);
        }
        if (thing->look == LOOK_ROPE && top == NULL) {
            top = thing;
        }
        if (thing->look == LOOK_BALL && thing->half[0] > 0.55f) {
            ball = thing;
        }
    }
    for (k = 0; k < 3 && top != NULL && ball != NULL; ++k) {
        const double apart = top->now.position[k] - ball->now.position[k];
        length += apart * apart;
    }
    printf("bridge: lowest plank at %.3f m\n", sag);
    printf("crane: three tonnes are %.3f m from the first link of 1 kg, of 5.200 m\n", sqrt(length));
    printf("tower: its top lies at %.2f m\n", top_of_tower(game)->now.position[1]);
    printf("wall: %d joints broken\n", game->bricks_broken);
}

int main(int argc, char **argv)
{
    static Game game;
    Camera camera = {{4, 8, 21}, {0.8, 3, 0}, 0.85f, WIDTH, HEIGHT};
    const char *picture = argc == 3 && strcmp(argv[1], "--picture") == 0 ? argv[2] : NULL;
    SDL_Window *window;
    SDL_GLContext context;
    double rest = 0.0;
    Uint64 last;
    int running = 1, debug = 0, frame = 0;

    if (SDL_Init(SDL_INIT_VIDEO) != 0) {
        fprintf(stderr, "%s\n", SDL_GetError());
        return 1;
    }
    window = SDL_CreateWindow("longspan", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, WIDTH, HEIGHT, SDL_WINDOW_OPENGL);
    context = window != NULL ? SDL_GL_CreateContext(window) : NULL;
    if (context == NULL) {
        fprintf(stderr, "%s\n", SDL_GetError());
        return 1;
    }
    scene_build(&game);
    last = SDL_GetPerformanceCounter();
    while (running) {
        const Uint64 now = SDL_GetPerformanceCounter();
        SDL_Event event;
        while (SDL_PollEvent(&event)) {
            if (event.type == SDL_QUIT) {
                running = 0;
            } else if (event.type == SDL_MOUSEBUTTONDOWN && event.button.button == SDL_BUTTON_LEFT) {
                hand_grab(&game, &camera, event.button.x, event.button.y);
            } else if (event.type == SDL_MOUSEMOTION) {
                hand_move(&game, &camera, event.motion.x, event.motion.y);
            } else if (event.type == SDL_MOUSEBUTTONUP) {
                hand_release(&game);
            } else if (event.type == SDL_KEYDOWN || event.type == SDL_KEYUP) {
                const int down = event.type == SDL_KEYDOWN, key = event.key.keysym.sym;
                if (key == SDLK_LEFT || key == SDLK_RIGHT) {
                    game.slew_speed = !down ? 0.0f : key == SDLK_LEFT ? 0.4f : -0.4f;
                } else if (down && key == SDLK_SPACE) {
                    scene_shoot(&game, GUN, WALL, 30.0f);
                } else if (down && key == SDLK_r) {
                    scene_reset(&game);
                } else if (down && key == SDLK_d) {
                    debug = !debug;
                } else if (down && key == SDLK_ESCAPE) {
                    running = 0;
                }
            }
        }
        if (picture != NULL) {
            play_script(&game, &camera, frame);
            scene_step(&game);
            /* A virtual display draws slowly, and only the end is looked at. */
            if (frame % 60 == 0 || frame == 599) {
                view_draw(&game, &camera, 1.0f, frame == 599 ? 0 : debug);
            }
        } else {
            rest = fmin(rest + (double)(now - last) / (double)SDL_GetPerformanceFrequency(), 4 * STEP);
            for (; rest >= STEP; rest -= STEP) {
                scene_step(&game);
            }
            view_draw(&game, &camera, (float)(rest / STEP), debug);
        }
        last = now;
        if (picture != NULL && ++frame == 600) {
            running = 0;
            if (!view_save(picture, WIDTH, HEIGHT)) {
                fprintf(stderr, "%s cannot be written\n", picture);
                return 1;
            }
        }
        SDL_GL_SwapWindow(window);
    }
    print_outcome(&game);
    check(ls_world_destroy(game.world));
    free(game.start);
    SDL_GL_DeleteContext(context);
    SDL_DestroyWindow(window);
    SDL_Quit();
    return 0;
}
