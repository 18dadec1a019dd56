/* A process that watches another one: attaches to a stream, follows it through the publisher's death and return, and prints the
 * world from the side, x to the right and y up. Run publish.c beside it.
 *
 *     cc renderer.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o renderer && ./renderer
 *
 * `./renderer SECONDS` watches for so long (1 s unless said), `./renderer SECONDS FILE` records what it sees,
 * `./renderer play FILE` plays a recording. */
#include "sample.h"

#include <math.h>
#include <string.h>
#include <time.h>

#define COLUMNS 72
#define ROWS 20

static char screen[ROWS][COLUMNS + 1];

static void put(double x, double y, char sign)
{
    const int column = (int)(COLUMNS / 2 + 5.0 * x), row = ROWS - 1 - (int)(1.6 * y);
    if (column >= 0 && column < COLUMNS && row >= 0 && row < ROWS)
        screen[row][column] = sign;
}

/* A body is drawn by points on the outline of its boxes and balls, turned as the body is about z. */
static void draw_shape(const LsStreamBody *body, const LsStreamShape *shape)
{
    const double angle = 2.0 * atan2(body->rotation[2], body->rotation[3]), c = cos(angle), s = sin(angle);
    const char sign = (body->flags & LS_STREAM_BODY_SUPPORT_KNOWN) && !(body->flags & LS_STREAM_BODY_SUPPORTED) ? '!' : '#';
    int i;
    for (i = 0; i < 64; ++i) {
        const double turn = i * 6.283185307 / 64;
        double x = cos(turn), y = sin(turn);
        if (shape->kind == LS_SHAPE_BOX) {
            const double reach = fmax(fabs(x), fabs(y));
            x *= shape->size[0] / reach;
            y *= shape->size[1] / reach;
        } else {
            x *= shape->size[0];
            y *= shape->size[0];
        }
        x += shape->position[0];
        y += shape->position[1];
        put(body->position[0] + c * x - s * y, body->position[1] + s * x + c * y, sign);
    }
}

/* Bodies come sorted by handle. */
static const LsStreamBody *find(const LsStreamBody *bodies, size_t count, uint64_t handle)
{
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = (low + high) / 2;
        if (bodies[middle].body < handle)
            low = middle + 1;
        else
            high = middle;
    }
    return low < count && bodies[low].body == handle ? &bodies[low] : NULL;
}

static void draw(LsStreamReader reader, const LsStreamPoll *poll)
{
    const LsStreamBody *bodies;
    const LsStreamShape *shapes;
    const LsStreamContact *contacts;
    size_t body_count, shape_count, contact_count, i;
    check(ls_stream_reader_bodies_get(reader, &bodies, &body_count));
    check(ls_stream_reader_shapes_get(reader, &shapes, &shape_count));
    check(ls_stream_reader_contacts_get(reader, &contacts, &contact_count));
    for (i = 0; i < ROWS; ++i) {
        memset(screen[i], i == ROWS - 1 ? '_' : ' ', COLUMNS);
        screen[i][COLUMNS] = 0;
    }
    for (i = 0; i < shape_count; ++i) {
        const LsStreamBody *body = find(bodies, body_count, shapes[i].body);
        if (body != NULL && (shapes[i].kind == LS_SHAPE_BOX || shapes[i].kind == LS_SHAPE_BALL))
            draw_shape(body, &shapes[i]);
    }
    for (i = 0; i < contact_count; ++i)
        put(contacts[i].points[0].position[0], contacts[i].points[0].position[1], '.');
    for (i = 0; i < ROWS; ++i)
        puts(screen[i]);
    printf("step %llu, %.2f s, %u bodies, %u contacts\n", (unsigned long long)poll->frame.step, poll->frame.time,
           (unsigned)body_count, (unsigned)contact_count);
}

int main(int argc, char **argv)
{
    const int plays = argc > 2 && strcmp(argv[1], "play") == 0;
    const double seconds = !plays && argc > 1 ? atof(argv[1]) : 1.0;
    LsStreamReaderDef def;
    LsStreamReader reader;
    LsStreamPoll poll;
    LsResult result = ls_stream_reader_def_init(&def, sizeof def);
    unsigned long long frames = 0, lost = 0;
    int status = -1;
    time_t end;

    if (result == LS_ERROR_UNSUPPORTED) {
        printf("this library was built without streams\n");
        return 0;
    }
    check(result);
    def.recording = plays ? argv[2] : NULL;
    check(ls_stream_reader_open(&def, &reader));
    if (!plays && argc > 2)
        check(ls_stream_reader_record(reader, argv[2]));

    end = time(NULL) + (time_t)ceil(seconds);
    while (plays || time(NULL) < end) {
        result = ls_stream_reader_poll(reader, plays ? 0.0f : 0.05f, &poll, sizeof poll);
        if (result == LS_ERROR_STREAM_CORRUPT || result == LS_ERROR_STREAM_INCOMPATIBLE) {
            fprintf(stderr, "%s\n", ls_last_error_message_get());
            continue;
        }
        check(result);
        if (poll.status == LS_STREAM_END)
            break;
        if (poll.status != status && poll.status == LS_STREAM_GONE)
            printf("nobody publishes\n");
        status = poll.status;
        if (status == LS_STREAM_FRAME) {
            ++frames;
            lost += poll.lost_frames;
            if (frames % 10 == 1)
                draw(reader, &poll);
        }
    }
    printf("%llu frames seen, %llu lost\n", frames, lost);
    check(ls_stream_reader_close(reader));
    return 0;
}
