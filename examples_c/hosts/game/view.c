#include <GL/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "game.h"

static const float COLORS[LOOK_COUNT][3] = {
    {0.36f, 0.42f, 0.34f}, {0.60f, 0.36f, 0.14f}, {0.95f, 0.78f, 0.10f}, {0.15f, 0.15f, 0.18f},
    {0.20f, 0.30f, 0.85f}, {0.55f, 0.25f, 0.65f}, {0.85f, 0.20f, 0.16f},
};
static const float SUN[3] = {0.35f, 0.85f, 0.40f};

/* Right, up and back of a camera. */
static void camera_axes(const Camera *camera, double axes[3][3])
{
    double length = 0.0;
    int i;
    for (i = 0; i < 3; ++i) {
        axes[2][i] = camera->eye[i] - camera->target[i];
        length += axes[2][i] * axes[2][i];
    }
    for (i = 0; i < 3; ++i) {
        axes[2][i] /= sqrt(length);
    }
    length = sqrt(axes[2][0] * axes[2][0] + axes[2][2] * axes[2][2]);
    axes[0][0] = axes[2][2] / length;
    axes[0][1] = 0.0;
    axes[0][2] = -axes[2][0] / length;
    for (i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        axes[1][i] = axes[2][j] * axes[0][k] - axes[2][k] * axes[0][j];
    }
}

LsRay camera_ray(const Camera *camera, int x, int y)
{
    LsRay ray;
    double axes[3][3], direction[3], length = 0.0;
    const double scale = tan(camera->field * 0.5) / (camera->height * 0.5);
    const double right = (x + 0.5 - camera->width * 0.5) * scale, up = (camera->height * 0.5 - y - 0.5) * scale;
    int i;
    camera_axes(camera, axes);
    for (i = 0; i < 3; ++i) {
        direction[i] = axes[0][i] * right + axes[1][i] * up - axes[2][i];
        length += direction[i] * direction[i];
    }
    for (i = 0; i < 3; ++i) {
        ray.origin[i] = camera->eye[i];
        ray.direction[i] = (float)(direction[i] / sqrt(length));
    }
    ray.length = 200.0f;
    return ray;
}

void camera_pixel(const Camera *camera, const double point[3], int *x, int *y)
{
    double axes[3][3], seen[3] = {0, 0, 0};
    const double scale = tan(camera->field * 0.5) / (camera->height * 0.5);
    int i, j;
    camera_axes(camera, axes);
    for (i = 0; i < 3; ++i) {
        for (j = 0; j < 3; ++j) {
            seen[i] += axes[i][j] * (point[j] - camera->eye[j]);
        }
    }
    *x = (int)(camera->width * 0.5 - seen[0] / seen[2] / scale);
    *y = (int)(camera->height * 0.5 + seen[1] / seen[2] / scale);
}

static void look_through(const Camera *camera)
{
    double axes[3][3], view[16] = {0}, depth = 0.0;
    const double near = 0.2, top = near * tan(camera->field * 0.5), side = top * camera->width / camera->height;
    int i, j;
    camera_axes(camera, axes);
    for (i = 0; i < 3; ++i) {
        depth = 0.0;
        for (j = 0; j < 3; ++j) {
            view[j * 4 + i] = axes[i][j];
            depth -= axes[i][j] * camera->eye[j];
        }
        view[12 + i] = depth;
    }
    view[15] = 1.0;
    glViewport(0, 0, camera->width, camera->height);
    glMatrixMode(GL_PROJECTION);
    glLoadIdentity();
    glFrustum(-side, side, -top, top, near, 200.0);
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixd(view);
}

/* Axes of a rotation, in columns. */
static void axes_of(const float q[4], float m[3][3])
{
    const float x = q[0], y = q[1], z = q[2], w = q[3];
    m[0][0] = 1 - 2 * (y * y + z * z);
    m[0][1] = 2 * (x * y - w * z);
    m[0][2] = 2 * (x * z + w * y);
    m[1][0] = 2 * (x * y + w * z);
    m[1][1] = 1 - 2 * (x * x + z * z);
    m[1][2] = 2 * (y * z - w * x);
    m[2][0] = 2 * (x * z - w * y);
    m[2][1] = 2 * (y * z + w * x);
    m[2][2] = 1 - 2 * (x * x + y * y);
}

static void vertex(const Thing *thing, const LsPose *pose, float m[3][3], const float normal[3], const float local[3])
{
    float light = 0.0f, at[3];
    int i;
    for (i = 0; i < 3; ++i) {
        light += SUN[i] * (m[i][0] * normal[0] + m[i][1] * normal[1] + m[i][2] * normal[2]);
        at[i] = (float)pose->position[i] + m[i][0] * local[0] + m[i][1] * local[1] + m[i][2] * local[2];
    }
    light = 0.55f + 0.45f * fmaxf(light, 0.0f);
    glColor3f(COLORS[thing->look][0] * light, COLORS[thing->look][1] * light, COLORS[thing->look][2] * light);
    glVertex3fv(at);
}

static void draw_box(const Thing *thing, const LsPose *pose)
{
    float m[3][3];
    int axis, sign, corner;
    axes_of(pose->rotation, m);
    glBegin(GL_QUADS);
    for (axis = 0; axis < 3; ++axis) {
        for (sign = -1; sign <= 1; sign += 2) {
            static const int around[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
            for (corner = 0; corner < 4; ++corner) {
                float normal[3] = {0, 0, 0}, local[3];
                normal[axis] = (float)sign;
                local[axis] = sign * thing->half[axis];
                local[(axis + 1) % 3] = around[corner][0] * thing->half[(axis + 1) % 3];
                local[(axis + 2) % 3] = sign * around[corner][1] * thing->half[(axis + 2) % 3];
                vertex(thing, pose, m, normal, local);
            }
        }
    }
    glEnd();
}

static void draw_ball(const Thing *thing, const LsPose *pose)
{
    const int rings = 12, sectors = 20;
    float m[3][3];
    int ring, sector, upper;
    axes_of(pose->rotation, m);
    for (ring = 0; ring < rings; ++ring) {
        glBegin(GL_TRIANGLE_STRIP);
        for (sector = 0; sector <= sectors; ++sector) {
            for (upper = 0; upper < 2; ++upper) {
                const float latitude = 3.14159265f * ((float)(ring + upper) / rings - 0.5f);
                const float longitude = 6.2831853f * sector / sectors;
                const float normal[3] = {cosf(latitude) * cosf(longitude), sinf(latitude), cosf(latitude) * sinf(longitude)};
                const float local[3] = {normal[0] * thing->half[0], normal[1] * thing->half[0], normal[2] * thing->half[0]};
                vertex(thing, pose, m, normal, local);
            }
        }
        glEnd();
    }
}

static void debug_line(const double *from, const double *to, uint32_t color, void *user)
{
    (void)user;
    glColor3ub((GLubyte)(color >> 16), (GLubyte)(color >> 8), (GLubyte)color);
    glVertex3dv(from);
    glVertex3dv(to);
}

static void draw_debug(const Game *game)
{
    LsDraw draw;
    check(ls_draw_init(&draw, sizeof draw));
    draw.layers = LS_DRAW_CONTACTS | LS_DRAW_JOINTS | LS_DRAW_JOINT_LOADS | LS_DRAW_BOUNDS;
    draw.line = debug_line;
    glDisable(GL_DEPTH_TEST);
    glBegin(GL_LINES);
    check(ls_world_draw(game->world, &draw));
    glEnd();
}

void view_draw(const Game *game, const Camera *camera, float share, int debug)
{
    size_t i;
    glClearColor(0.62f, 0.76f, 0.90f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    look_through(camera);
    for (i = 0; i < game->count; ++i) {
        const Thing *thing = &game->things[i];
        LsPose pose = thing->now;
        float dot = 0.0f, length = 0.0f;
        int k;
        for (k = 0; k < 4; ++k) {
            dot += thing->before.rotation[k] * thing->now.rotation[k];
        }
        for (k = 0; k < 3; ++k) {
            pose.position[k] = thing->before.position[k] + (thing->now.position[k] - thing->before.position[k]) * share;
        }
        for (k = 0; k < 4; ++k) {
            const float to = dot < 0.0f ? -thing->now.rotation[k] : thing->now.rotation[k];
            pose.rotation[k] = thing->before.rotation[k] + (to - thing->before.rotation[k]) * share;
            length += pose.rotation[k] * pose.rotation[k];
        }
        for (k = 0; k < 4; ++k) {
            pose.rotation[k] /= sqrtf(length);
        }
        if (thing->is_ball) {
            draw_ball(thing, &pose);
        } else {
            draw_box(thing, &pose);
        }
    }
    if (debug) {
        draw_debug(game);
    }
}

int view_save(const char *path, int width, int height)
{
    unsigned char *pixels = (unsigned char *)malloc((size_t)width * (size_t)height * 3);
    FILE *file = fopen(path, "wb");
    int row, ok = pixels != NULL && file != NULL;
    if (ok) {
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, pixels);
        fprintf(file, "P6\n%d %d\n255\n", width, height);
        for (row = height - 1; row >= 0; --row) {
            ok = ok && fwrite(pixels + (size_t)row * (size_t)width * 3, 3, (size_t)width, file) == (size_t)width;
        }
    }
    if (file != NULL) {
        ok = fclose(file) == 0 && ok;
    }
    free(pixels);
    return ok;
}
