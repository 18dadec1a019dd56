/* A world out of a file: what ls_world_save has written is taken up in another process, and goes on.
 *
 *     cc saved.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o saved && ./saved
 *
 * `./saved FILE SECONDS` goes on with the world in FILE for so long; `longspan-bench save SCENE FILE` writes one of any scene that
 * the library is measured with. Without a file, it writes one of its own first. */
#include "sample.h"

#define DT (1.0f / 60.0f)

static uint64_t hash_of(LsWorld world)
{
    uint64_t hash;
    check(ls_world_state_hash_get(world, &hash));
    return hash;
}

/* Writes a world to a file from its first byte on. */
static void save(LsWorld world, FILE *file)
{
    size_t size;
    void *bytes;
    expect(ls_world_save(world, NULL, 0, &size) == LS_ERROR_BUFFER_TOO_SMALL, "without a buffer the call says how large it must be");
    bytes = malloc(size);
    expect(bytes != NULL, "there is memory");
    check(ls_world_save(world, bytes, size, &size));
    rewind(file);
    expect(fwrite(bytes, 1, size, file) == size && fflush(file) == 0, "the file is written");
    free(bytes);
}

/* Makes a world of what a file holds. */
static LsWorld load(FILE *file)
{
    LsWorld world = create_world();
    unsigned char *bytes = NULL;
    size_t size = 0, capacity = 0, got;
    rewind(file);
    do {
        capacity = 2 * capacity + 65536;
        bytes = (unsigned char *)realloc(bytes, capacity);
        expect(bytes != NULL, "there is memory");
        got = fread(bytes + size, 1, capacity - size, file);
        size += got;
    } while (got > 0);
    check(ls_world_restore(world, bytes, size));
    free(bytes);
    return world;
}

/* A pyramid that a ball falls on, saved when the ball has nearly reached it; the hash of the world half a second later. */
static uint64_t make_one(FILE *file)
{
    LsWorld world = create_world();
    uint64_t hash;
    int row, place, step;
    create_body(world, LS_BODY_STATIC, LS_SHAPE_HALF_SPACE, 0.0, 0.0);
    for (row = 0; row < 6; ++row)
        for (place = 0; place < 6 - row; ++place)
            create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 1.05 * place + 0.525 * row, 0.5 + row);
    create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BALL, 2.4, 9.0);
    for (step = 0; step < 40; ++step)
        check(ls_world_step(world, DT));
    save(world, file);
    for (step = 0; step < 30; ++step)
        check(ls_world_step(world, DT));
    hash = hash_of(world);
    check(ls_world_destroy(world));
    return hash;
}

int main(int argc, char **argv)
{
    const int steps = argc > 2 ? (int)(atof(argv[2]) / DT) : 30;
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : tmpfile();
    uint64_t expected = 0;
    LsStepReport report;
    LsWorld world;
    double time = 0.0;
    size_t bodies;
    int step;

    if (file == NULL) {
        perror(argc > 1 ? argv[1] : "a temporary file");
        return 1;
    }
    if (argc == 1)
        expected = make_one(file);
    world = load(file);
    fclose(file);
    for (step = 0; step < steps; ++step) {
        step_world(world, DT);
        check(ls_world_report_get(world, &report, sizeof report));
        time += report.total_time;
    }
    check(ls_world_body_count_get(world, &bodies));
    printf("%u bodies, %d steps, %.0f us a step, hash %016llx\n", (unsigned)bodies, steps, 1e6 * time / (steps > 0 ? steps : 1),
           (unsigned long long)hash_of(world));
    expect(argc > 1 || hash_of(world) == expected, "it is the world that was saved, to the last bit");
    check(ls_world_destroy(world));
    return 0;
}
