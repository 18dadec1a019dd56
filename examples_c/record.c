/* Every call that changes a world, written down, played again, and the first call that came out otherwise.
 *
 *     cc record.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o record && ./record
 *
 * A host that records from the start can send a bug as a file: ls_recording_replay does it again, step by step. */
#include "sample.h"

#include <string.h>

typedef struct Tape {
    unsigned char *bytes;
    size_t size, capacity;
} Tape;

static int32_t keep(const void *data, size_t size, void *user)
{
    Tape *tape = (Tape *)user;
    if (tape->size + size > tape->capacity) {
        tape->capacity = 2 * (tape->size + size);
        tape->bytes = (unsigned char *)realloc(tape->bytes, tape->capacity);
        if (tape->bytes == NULL) {
            exit(1);
        }
    }
    memcpy(tape->bytes + tape->size, data, size);
    tape->size += size;
    return 0;
}

int main(void)
{
    LsWorld world = create_world(), again;
    Tape tape = {NULL, 0, 0};
    LsBody boxes[8];
    const float push[3] = {4000, 0, 500};
    uint64_t hash, hash_again;
    LsReplay report;
    size_t at;
    int i, found = 0;

    create_body(world, LS_BODY_STATIC, LS_SHAPE_HALF_SPACE, 0, 0);
    check(ls_world_recording_start(world, keep, LS_RECORD_HASH_EVERY_CALL, &tape));
    for (i = 0; i < 8; ++i) {
        boxes[i] = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0.05 * (i % 3), 0.5 + 1.01 * i);
    }
    for (i = 0; i < 90; ++i) {
        if (i == 30) {
            check(ls_body_impulse_add(world, boxes[3], push));
        }
        if (i == 60) {
            check(ls_body_destroy(world, boxes[7]));
            expect(ls_body_destroy(world, boxes[7]) == LS_ERROR_ALREADY_DESTROYED, "it is gone");
        }
        check(ls_world_step(world, 1.0f / 60.0f));
    }
    check(ls_world_state_hash_get(world, &hash));
    check(ls_world_recording_stop(world));
    printf("%u bytes for 8 boxes and 90 steps\n", (unsigned)tape.size);

    check(ls_recording_replay(tape.bytes, tape.size, UINT64_MAX, &again, &report, sizeof report));
    check(ls_world_state_hash_get(again, &hash_again));
    printf("%d calls, %d refused, %d steps, the same bits: %s\n", (int)report.calls, (int)report.refused, (int)report.steps,
           hash == hash_again ? "yes" : "no");
    expect(hash == hash_again && report.steps == 90 && report.refused == 1 && !report.diverged && !report.cut_short, "the same");
    check(ls_world_destroy(again));

    /* Another push than the one that was given: 5000 N s in place of 4000. */
    for (at = 0; at + 4 <= tape.size && !found; ++at) {
        static const unsigned char given[2] = {0x7a, 0x45}, other[2] = {0x9c, 0x45}; /* upper half of the floats */
        if (memcmp(tape.bytes + at, given, 2) == 0) {
            memcpy(tape.bytes + at, other, 2);
            if (ls_recording_replay(tape.bytes, tape.size, UINT64_MAX, NULL, &report, sizeof report) == LS_OK
                && strcmp(report.method, "add_impulse") == 0) {
                printf("call %d, %s in step %d, is the first that differs\n", (int)report.call, report.method, (int)report.step + 1);
                expect(report.diverged && report.in_state && report.step == 30 && report.found != report.recorded, "it is named");
                found = 1;
            }
            memcpy(tape.bytes + at, given, 2);
        }
    }
    expect(found, "the changed call is found");
    tape.bytes[17] ^= 1;
    expect(ls_recording_replay(tape.bytes, tape.size, 1, NULL, &report, sizeof report) == LS_ERROR_INVALID_SNAPSHOT, "foreign");
    expect(ls_world_recording_stop(world) == LS_ERROR_NOT_APPLICABLE, "there is none any more");
    free(tape.bytes);
    check(ls_world_destroy(world));
    return 0;
}
