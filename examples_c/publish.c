/* A tower under a falling ball, published for other processes: run it, and then renderer.c, or the viewer, beside it.
 *
 *     cc publish.c -I../include -L../target/release -l:liblongspan.a -lm -lpthread -ldl -o publish && ./publish
 *
 * `./publish SECONDS` goes on for so long in real time (1 s unless said). The library must have been built with
 * `--features stream`; one without says so. */
#include "sample.h"

int main(int argc, char **argv)
{
    const double seconds = argc > 1 ? atof(argv[1]) : 1.0;
    const float dt = 1.0f / 60.0f;
    LsWorld world = create_world();
    LsStreamDef def;
    LsStream stream;
    LsStreamStats stats;
    LsStepReport report;
    LsResult result;
    double start, in_steps = 0.0, in_stream = 0.0;
    int step, floor_number, steps = (int)(seconds * 60.0);

    create_body(world, LS_BODY_STATIC, LS_SHAPE_HALF_SPACE, 0.0, 0.0);
    for (floor_number = 0; floor_number < 10; ++floor_number) {
        create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, -0.8, 0.5 + floor_number);
        create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BOX, 0.8, 0.5 + floor_number);
    }
    create_body(world, LS_BODY_DYNAMIC, LS_SHAPE_BALL, 0.0, 12.0);
    check(ls_support_enabled_set(world, 1));

    result = ls_stream_def_init(&def, sizeof def);
    if (result == LS_ERROR_UNSUPPORTED) {
        printf("this library was built without streams\n");
        return 0;
    }
    check(result);
    def.name = "tower";
    def.layers = LS_STREAM_LAYER_CONTACTS;
    check(ls_stream_open(world, &def, &stream));

    start = now();
    for (step = 0; step < steps; ++step) {
        check(ls_world_step(world, dt)); /* publishes */
        check(ls_world_report_get(world, &report, sizeof report));
        check(ls_stream_stats_get(stream, &stats, sizeof stats));
        in_steps += report.total_time;
        in_stream += stats.seconds;
        wait_until(start + (step + 1) * (double)dt);
    }
    printf("%llu frames and %llu messages of records published, %llu dropped\n", (unsigned long long)stats.frames,
           (unsigned long long)stats.records, (unsigned long long)stats.dropped);
    printf("a step took %.1f us, publishing it %.1f us\n", 1e6 * in_steps / steps, 1e6 * in_stream / steps);
    expect(stats.dropped == 0, "everything was placed");
    check(ls_stream_close(stream));
    check(ls_world_destroy(world));
    return 0;
}
