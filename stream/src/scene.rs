//! What a reader knows of a world: all messages so far, put together.

use std::collections::BTreeMap;

use bytemuck::Zeroable;
use longspan_stream_schema::{
    ContentHash, LS_STREAM_BODY_SUPPORT_KNOWN, LS_STREAM_BODY_SUPPORTED, LS_STREAM_CHANNEL_COLD, LS_STREAM_CHANNEL_HOT,
    LS_STREAM_CYCLE_BEGINS, LS_STREAM_CYCLE_ENDS, LS_STREAM_EVENT_SUPPORT_GAINED, LS_STREAM_EVENT_SUPPORT_LOST,
    LS_STREAM_SECTION_BODY_GONE, LS_STREAM_SECTION_GEOMETRY, LS_STREAM_SECTION_JOINT_GONE, LS_STREAM_SECTION_SHAPE_GONE,
    LsStreamBody, LsStreamBound, LsStreamBreak, LsStreamContact, LsStreamEvent, LsStreamGeometry, LsStreamGone, LsStreamHeader,
    LsStreamJoint, LsStreamJointLoad, LsStreamMotion, LsStreamPiece, LsStreamPlane, LsStreamShape, LsStreamWorld,
};

use crate::message::{Message, Section, Sections, header};
use crate::problem::{Problem, Result};

/// Most objects of a kind that a scene takes; whoever sends more means harm.
const MAX_OBJECTS: usize = 1 << 22;

/// Most vertices or triangles of one form.
const MAX_MESH: u32 = 1 << 24;

/// Most events that are kept until somebody reads them.
const MAX_EVENTS: usize = 1 << 16;

/// Triangles of a form.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertices (m).
    pub vertices: Vec<[f32; 3]>,
    /// Three vertices a triangle, counter-clockwise seen from outside; each is less than the number of vertices.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices and triangles that have not come yet.
    missing: usize,
}

impl Mesh {
    /// Whether all of it has come.
    pub fn is_complete(&self) -> bool {
        self.missing == 0
    }
}

/// A record, and the number of the message that it came with.
#[derive(Debug, Clone, Copy)]
struct Told<T> {
    record: T,
    sequence: u64,
}

/// A world as far as its messages have told.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// Life of the publisher that all this comes from.
    session: u64,
    world: LsStreamWorld,
    frame: LsStreamHeader,
    bodies: BTreeMap<u64, Told<LsStreamBody>>,
    shapes: BTreeMap<(u64, u32), Told<LsStreamShape>>,
    joints: BTreeMap<u64, Told<LsStreamJoint>>,
    meshes: BTreeMap<(u64, u32), Mesh>,
    contacts: Vec<LsStreamContact>,
    joint_loads: Vec<LsStreamJointLoad>,
    bounds: Vec<LsStreamBound>,
    planes: Vec<LsStreamPlane>,
    events: Vec<LsStreamEvent>,
    breaks: Vec<LsStreamBreak>,
    pieces: Vec<LsStreamPiece>,
    /// Message with which the cycle under way began, if none was missed since.
    cycle_begin: Option<u64>,
    cold_sequence: u64,
    complete: bool,
}

impl Scene {
    /// The world's settings.
    pub fn world(&self) -> &LsStreamWorld {
        &self.world
    }

    /// Header of the last frame; all zero before the first.
    pub fn frame(&self) -> &LsStreamHeader {
        &self.frame
    }

    /// Whether the whole world has been told, and nothing was missed since.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    /// Bodies, by handle.
    pub fn bodies(&self) -> impl ExactSizeIterator<Item = &LsStreamBody> {
        self.bodies.values().map(|told| &told.record)
    }

    /// A body.
    pub fn body(&self, body: u64) -> Option<&LsStreamBody> {
        self.bodies.get(&body).map(|told| &told.record)
    }

    /// Shapes, by handle and part.
    pub fn shapes(&self) -> impl ExactSizeIterator<Item = &LsStreamShape> {
        self.shapes.values().map(|told| &told.record)
    }

    /// Joints, by handle.
    pub fn joints(&self) -> impl ExactSizeIterator<Item = &LsStreamJoint> {
        self.joints.values().map(|told| &told.record)
    }

    /// A joint.
    pub fn joint(&self, joint: u64) -> Option<&LsStreamJoint> {
        self.joints.get(&joint).map(|told| &told.record)
    }

    /// Triangles of a part of a shape that has no simple form.
    pub fn mesh(&self, shape: u64, part: u32) -> Option<&Mesh> {
        self.meshes.get(&(shape, part)).filter(|mesh| mesh.is_complete())
    }

    /// Contacts of the last frame, if the stream has them.
    pub fn contacts(&self) -> &[LsStreamContact] {
        &self.contacts
    }

    /// Loads of joints in the last frame, if the stream has them.
    pub fn joint_loads(&self) -> &[LsStreamJointLoad] {
        &self.joint_loads
    }

    /// Bounds in the last frame, if the stream has them.
    pub fn bounds(&self) -> &[LsStreamBound] {
        &self.bounds
    }

    /// Planes of hinge chains in the last frame, if the stream has them.
    pub fn planes(&self) -> &[LsStreamPlane] {
        &self.planes
    }

    /// Events that came since the last call of [`forget_events`](Self::forget_events), the oldest first.
    pub fn events(&self) -> &[LsStreamEvent] {
        &self.events
    }

    /// Joints that broke since then, the oldest first.
    pub fn breaks(&self) -> &[LsStreamBreak] {
        &self.breaks
    }

    /// Pieces of unions that fell apart since then, the oldest first.
    pub fn pieces(&self) -> &[LsStreamPiece] {
        &self.pieces
    }

    /// Empties the lists of events, breaks and pieces.
    pub fn forget_events(&mut self) {
        self.events.clear();
        self.breaks.clear();
        self.pieces.clear();
    }

    /// Hash of the step, of the handles, poses, velocities and flags of all bodies, and of the joints.
    pub fn hash(&self) -> u64 {
        let mut hash = ContentHash::default();
        hash.add(&self.frame.step.to_le_bytes());
        for told in self.bodies.values() {
            // When it was last told of is no part of the picture.
            hash.add(bytemuck::bytes_of(&LsStreamBody { step: 0, ..told.record }));
        }
        for told in self.joints.values() {
            hash.add(bytemuck::bytes_of(&told.record));
        }
        hash.finish()
    }

    /// Takes in a message.
    ///
    /// # Errors
    /// `Corrupt` where a record makes no sense; the scene is as it was, or has taken in records before that one.
    pub fn apply(&mut self, message: &Message<'_>) -> Result<()> {
        if self.session != message.header.session {
            *self = Self { session: message.header.session, ..Self::default() };
        }
        if message.header.channel == LS_STREAM_CHANNEL_COLD { self.apply_cold(message) } else { self.apply_frame(message) }
    }

    /// Notes that messages of the cold channel were missed: what is known may be out of date until it has all been told again.
    pub(crate) fn missed_records(&mut self) {
        self.cycle_begin = None;
        self.complete = false;
    }

    fn apply_frame(&mut self, message: &Message<'_>) -> Result<()> {
        self.contacts.clear();
        self.joint_loads.clear();
        self.bounds.clear();
        self.planes.clear();
        for section in message.sections() {
            for motion in section.records::<LsStreamMotion>() {
                self.apply_motion(&motion?, message.header.step);
            }
            collect(&section, &mut self.contacts)?;
            collect(&section, &mut self.joint_loads)?;
            collect(&section, &mut self.bounds)?;
            collect(&section, &mut self.planes)?;
        }
        self.frame = message.header;
        Ok(())
    }

    fn apply_motion(&mut self, motion: &LsStreamMotion, step: u64) {
        let Some(Told { record: body, .. }) = self.bodies.get_mut(&motion.body) else { return };
        if body.step > step {
            return;
        }
        *body = LsStreamBody {
            user_word: motion.user_word,
            union_id: motion.union_id,
            step,
            position: motion.position,
            rotation: motion.rotation,
            linear_velocity: motion.linear_velocity,
            angular_velocity: motion.angular_velocity,
            flags: motion.flags,
            ..*body
        };
    }

    fn apply_cold(&mut self, message: &Message<'_>) -> Result<()> {
        let LsStreamHeader { sequence, flags, .. } = message.header;
        if self.cold_sequence.wrapping_add(1) != sequence {
            self.missed_records();
        }
        self.cold_sequence = sequence;
        if flags & LS_STREAM_CYCLE_BEGINS != 0 {
            self.cycle_begin = Some(sequence);
        }
        for section in message.sections() {
            self.apply_section(&section, sequence)?;
        }
        if flags & LS_STREAM_CYCLE_ENDS != 0
            && let Some(begin) = self.cycle_begin.take()
        {
            self.bodies.retain(|_, told| told.sequence >= begin);
            self.shapes.retain(|_, told| told.sequence >= begin);
            self.joints.retain(|_, told| told.sequence >= begin);
            let shapes = &self.shapes;
            self.meshes.retain(|key, _| shapes.contains_key(key));
            self.complete = true;
        }
        Ok(())
    }

    fn apply_section(&mut self, section: &Section<'_>, sequence: u64) -> Result<()> {
        for world in section.records::<LsStreamWorld>() {
            self.world = world?;
        }
        for body in section.records::<LsStreamBody>() {
            self.apply_body(body?, sequence);
        }
        for shape in section.records::<LsStreamShape>() {
            let record = shape?;
            self.shapes.insert((record.shape, record.part), Told { record, sequence });
        }
        for joint in section.records::<LsStreamJoint>() {
            let record = joint?;
            self.joints.insert(record.joint, Told { record, sequence });
        }
        for gone in section.plain::<LsStreamGone>(LS_STREAM_SECTION_BODY_GONE) {
            self.bodies.remove(&gone.id);
        }
        for gone in section.plain::<LsStreamGone>(LS_STREAM_SECTION_JOINT_GONE) {
            self.joints.remove(&gone.id);
        }
        for gone in section.plain::<LsStreamGone>(LS_STREAM_SECTION_SHAPE_GONE) {
            self.shapes.retain(|&(shape, _), _| shape != gone.id);
            self.meshes.retain(|&(shape, _), _| shape != gone.id);
        }
        for event in section.records::<LsStreamEvent>() {
            self.apply_event(event?);
        }
        collect(section, &mut self.breaks)?;
        collect(section, &mut self.pieces)?;
        self.breaks.truncate(MAX_EVENTS);
        self.pieces.truncate(MAX_EVENTS);
        if section.kind == LS_STREAM_SECTION_GEOMETRY {
            self.apply_geometry(section.bytes())?;
        }
        if [self.bodies.len(), self.shapes.len(), self.joints.len()].into_iter().any(|count| count > MAX_OBJECTS) {
            return Err(Problem::Corrupt("more objects than a world can hold"));
        }
        Ok(())
    }

    /// What was told of a body holds until it is told anew; but where it is, a later frame may have said already.
    fn apply_body(&mut self, record: LsStreamBody, sequence: u64) {
        let told = self.bodies.entry(record.body).or_insert(Told { record, sequence });
        let known = told.record;
        told.sequence = sequence;
        told.record = record;
        if known.step > record.step {
            told.record = LsStreamBody {
                step: known.step,
                position: known.position,
                rotation: known.rotation,
                linear_velocity: known.linear_velocity,
                angular_velocity: known.angular_velocity,
                flags: known.flags,
                ..record
            };
        }
    }

    fn apply_event(&mut self, event: LsStreamEvent) {
        if let Some(told) = self.bodies.get_mut(&event.a) {
            let flags = &mut told.record.flags;
            match event.kind {
                LS_STREAM_EVENT_SUPPORT_GAINED => *flags |= LS_STREAM_BODY_SUPPORT_KNOWN | LS_STREAM_BODY_SUPPORTED,
                LS_STREAM_EVENT_SUPPORT_LOST => {
                    *flags = *flags & !LS_STREAM_BODY_SUPPORTED | LS_STREAM_BODY_SUPPORT_KNOWN;
                }
                _ => {}
            }
        }
        if self.events.len() < MAX_EVENTS {
            self.events.push(event);
        }
    }

    fn apply_geometry(&mut self, bytes: &[u8]) -> Result<()> {
        const CUT: Problem = Problem::Corrupt("a form ends before its triangles");
        const SENSE: Problem = Problem::Corrupt("a form has triangles that it cannot have");
        let (head, rest) = bytes.split_at_checked(size_of::<LsStreamGeometry>()).ok_or(CUT)?;
        let part: LsStreamGeometry = bytemuck::pod_read_unaligned(head);
        let LsStreamGeometry { vertex_total, triangle_total, vertex_count, triangle_count, .. } = part;
        let (vertices, rest) = rest.split_at_checked(12 * vertex_count as usize).ok_or(CUT)?;
        let (triangles, _) = rest.split_at_checked(12 * triangle_count as usize).ok_or(CUT)?;
        if vertex_total > MAX_MESH || triangle_total > MAX_MESH || self.meshes.len() > MAX_OBJECTS {
            return Err(SENSE);
        }
        let key = (part.shape, part.part);
        let begins = part.first_vertex == 0 && part.first_triangle == 0;
        let mesh = self.meshes.entry(key).or_default();
        // A form whose surface was told already stays to be seen while it is told again.
        let known =
            mesh.is_complete() && (mesh.vertices.len(), mesh.triangles.len()) == (vertex_total as usize, triangle_total as usize);
        if begins && !known {
            *mesh = Mesh { missing: vertex_total as usize + triangle_total as usize, ..Mesh::default() };
        }
        let follows = mesh.vertices.len() == part.first_vertex as usize && mesh.triangles.len() == part.first_triangle as usize;
        if known || !follows {
            return Ok(());
        }
        if vertex_count as usize + triangle_count as usize > mesh.missing {
            return Err(SENSE);
        }
        for vertex in vertices.chunks_exact(12).map(bytemuck::pod_read_unaligned::<[f32; 3]>) {
            if !vertex.iter().all(|x| x.is_finite()) {
                return Err(SENSE);
            }
            mesh.vertices.push(vertex);
        }
        for triangle in triangles.chunks_exact(12).map(bytemuck::pod_read_unaligned::<[u32; 3]>) {
            if triangle.iter().any(|&corner| corner >= vertex_total) {
                return Err(SENSE);
            }
            mesh.triangles.push(triangle);
        }
        mesh.missing -= vertex_count as usize + triangle_count as usize;
        Ok(())
    }

    /// Forgets everything.
    pub(crate) fn begin_anew(&mut self) {
        *self = Self::default();
    }

    /// Number that differs between any two lives of a publisher; 0 before the first message.
    pub fn session(&self) -> u64 {
        self.session
    }

    /// Appends two messages that make a new scene what this one is, but for events: one of the cold channel, one of the hot.
    pub(crate) fn write_keyframe(&self, out: &mut Vec<u8>) {
        let mut sections = Sections::default();
        sections.push(&self.world);
        self.bodies().for_each(|body| sections.push(body));
        self.shapes().for_each(|shape| sections.push(shape));
        self.joints().for_each(|joint| sections.push(joint));
        for (&(shape, part), mesh) in self.meshes.iter().filter(|(_, mesh)| mesh.is_complete()) {
            let (vertices, triangles) = (mesh.vertices.len() as u32, mesh.triangles.len() as u32);
            sections.begin_bytes(LS_STREAM_SECTION_GEOMETRY);
            sections.add_bytes(bytemuck::bytes_of(&LsStreamGeometry {
                shape,
                part,
                vertex_total: vertices,
                triangle_total: triangles,
                vertex_count: vertices,
                triangle_count: triangles,
                ..LsStreamGeometry::zeroed()
            }));
            sections.add_bytes(bytemuck::cast_slice(&mesh.vertices));
            sections.add_bytes(bytemuck::cast_slice(&mesh.triangles));
            sections.close();
        }
        let mut head = LsStreamHeader {
            sequence: self.cold_sequence,
            step: self.frame.step,
            time: self.frame.time,
            flags: if self.complete { LS_STREAM_CYCLE_BEGINS | LS_STREAM_CYCLE_ENDS } else { 0 },
            ..header(LS_STREAM_CHANNEL_COLD, self.session)
        };
        let content = sections.finish(&mut head);
        out.extend_from_slice(bytemuck::bytes_of(&head));
        out.extend_from_slice(content);

        sections.clear();
        self.contacts.iter().for_each(|contact| sections.push(contact));
        self.joint_loads.iter().for_each(|load| sections.push(load));
        self.bounds.iter().for_each(|bound| sections.push(bound));
        self.planes.iter().for_each(|plane| sections.push(plane));
        let LsStreamHeader { magic, schema, header_size, layout_hash, session, channel, .. } =
            header(LS_STREAM_CHANNEL_HOT, self.session);
        let mut head = LsStreamHeader { magic, schema, header_size, layout_hash, session, channel, ..self.frame };
        let content = sections.finish(&mut head);
        out.extend_from_slice(bytemuck::bytes_of(&head));
        out.extend_from_slice(content);
    }
}

fn collect<T: longspan_stream_schema::Wire>(section: &Section<'_>, into: &mut Vec<T>) -> Result<()> {
    for record in section.records::<T>() {
        into.push(record?);
    }
    Ok(())
}
