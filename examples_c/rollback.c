/* Save, go on, go back, go on again: the second time gives the same bits. A host that predicts what other players do needs this.
 *
 *     cc rollback.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o rollback && ./rollback */
#include "sample.h"

#define BOXES 30
#define STEPS 120

static uint64_t step_and_hash(LsWorld world)
{
    uint64_t hash;
    check(ls_world_step(world, 1.0f / 60.0f));
    check(ls_world_state_hash_get(world, &hash));
    return hash;
}

int main(void)
{
    LsWorld world = create_world();
    LsBody first;
    LsPose pose;
    uint64_t hashes[STEPS];
    void *snapshot;
    size_t size;
    int i;

    create_body(world, LS_BODY_STATIC, LS_SHAPE_HALF_SPACE, 0, 0);
    first = create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0, 1);
    for (i = 1; i < BOXES; ++i) {
        create_body(world, LS_BODY_DYNAMIC, i % 3 ? LS_SHAPE_BOX : LS_SHAPE_BALL, 0.3 * (i % 4), 1.0 + 1.1 * i);
    }
    for (i = 0; i < 60; ++i) {
        step_and_hash(world);
    }

    /* Without a buffer, the call says how large it must be. */
    if (ls_world_save(world, NULL, 0, &size) != LS_ERROR_BUFFER_TOO_SMALL) {
        return 1;
    }
    snapshot = malloc(size);
    if (snapshot == NULL) {
        return 1;
    }
    check(ls_world_save(world, snapshot, size, &size));
    printf("%u bytes for %d bodies\n", (unsigned)size, BOXES + 1);

    for (i = 0; i < STEPS; ++i) {
        hashes[i] = step_and_hash(world);
    }
    check(ls_body_destroy(world, first));
    check(ls_world_restore(world, snapshot, size));
    check(ls_body_pose_get(world, first, &pose)); /* it exists again */
    for (i = 0; i < STEPS; ++i) {
        if (step_and_hash(world) != hashes[i]) {
            fprintf(stderr, "step %d differs\n", i);
            return 1;
        }
    }
    printf("%d steps, the same bits twice\n", STEPS);

    ((unsigned char *)snapshot)[size / 2] ^= 1;
    if (ls_world_restore(world, snapshot, size) != LS_ERROR_INVALID_SNAPSHOT) {
        return 1;
    }
    printf("%s\n", ls_last_error_message_get());
    free(snapshot);
    check(ls_world_destroy(world));
    return 0;
}
