/* Every function of streams in a library that was built without them. */
#include <stdio.h>
#include <string.h>

#include "longspan/longspan.h"

#define REFUSED(call)                                                                                                              \
    do {                                                                                                                           \
        if ((call) != LS_ERROR_UNSUPPORTED) {                                                                                      \
            printf("%s is not refused\n", #call);                                                                                  \
            return 1;                                                                                                              \
        }                                                                                                                          \
    } while (0)

int main(void)
{
    const LsWorld world = {0};
    const LsStream stream = {0};
    const LsStreamReader reader = {0};
    LsStream opened;
    LsStreamReader reading;
    LsStreamDef def;
    LsStreamReaderDef reader_def;
    LsStreamStats stats;
    LsStreamPoll poll;
    LsStreamRecording recording;
    LsStreamWorld told;
    LsStreamSource sources[1];
    const LsStreamBody *bodies;
    const LsStreamShape *shapes;
    const LsStreamJoint *joints;
    const LsStreamContact *contacts;
    const LsStreamJointLoad *loads;
    const LsStreamBound *bounds;
    const LsStreamPlane *planes;
    const LsStreamEvent *events;
    const LsStreamBreak *breaks;
    const LsStreamPiece *pieces;
    const float(*vertices)[3];
    const uint32_t(*triangles)[3];
    size_t count, other;
    uint64_t hash;
    memset(&def, 0, sizeof def);
    memset(&reader_def, 0, sizeof reader_def);
    REFUSED(ls_stream_def_init(&def, sizeof def));
    REFUSED(ls_stream_open(world, &def, &opened));
    REFUSED(ls_stream_close(stream));
    REFUSED(ls_stream_serve(stream));
    REFUSED(ls_stream_stats_get(stream, &stats, sizeof stats));
    REFUSED(ls_stream_sources_get(NULL, sources, 1, &count));
    REFUSED(ls_stream_reader_def_init(&reader_def, sizeof reader_def));
    REFUSED(ls_stream_reader_open(&reader_def, &reading));
    REFUSED(ls_stream_reader_close(reader));
    REFUSED(ls_stream_reader_poll(reader, 0.0f, &poll, sizeof poll));
    REFUSED(ls_stream_reader_next(reader, &poll, sizeof poll));
    REFUSED(ls_stream_reader_seek(reader, 1, &poll, sizeof poll));
    REFUSED(ls_stream_reader_world_get(reader, &told));
    REFUSED(ls_stream_reader_bodies_get(reader, &bodies, &count));
    REFUSED(ls_stream_reader_shapes_get(reader, &shapes, &count));
    REFUSED(ls_stream_reader_joints_get(reader, &joints, &count));
    REFUSED(ls_stream_reader_contacts_get(reader, &contacts, &count));
    REFUSED(ls_stream_reader_joint_loads_get(reader, &loads, &count));
    REFUSED(ls_stream_reader_bounds_get(reader, &bounds, &count));
    REFUSED(ls_stream_reader_planes_get(reader, &planes, &count));
    REFUSED(ls_stream_reader_events_get(reader, &events, &count));
    REFUSED(ls_stream_reader_breaks_get(reader, &breaks, &count));
    REFUSED(ls_stream_reader_pieces_get(reader, &pieces, &count));
    REFUSED(ls_stream_reader_mesh_get(reader, 1, 0, &vertices, &count, &triangles, &other));
    REFUSED(ls_stream_reader_hash_get(reader, &hash));
    REFUSED(ls_stream_reader_record(reader, NULL));
    REFUSED(ls_stream_reader_recording_get(reader, &recording, sizeof recording));
    return 0;
}
