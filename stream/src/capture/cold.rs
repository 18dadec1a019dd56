//! The cold channel: what the world consists of and what happened, in blocks.

use std::collections::VecDeque;

use longspan::{BodyId, Handle, JointId, ShapeId, World};
use longspan_stream_schema::{
    LS_STREAM_BODY_BROKEN, LS_STREAM_BODY_SUPPORT_KNOWN, LS_STREAM_BODY_SUPPORTED, LS_STREAM_CHANNEL_COLD,
    LS_STREAM_CYCLE_BEGINS, LS_STREAM_CYCLE_ENDS, LS_STREAM_EVENT_CONTACT_BEGAN, LS_STREAM_EVENT_CONTACT_ENDED,
    LS_STREAM_EVENT_OVERLOAD, LS_STREAM_EVENT_QUARANTINED, LS_STREAM_EVENT_SUPPORT_GAINED, LS_STREAM_EVENT_SUPPORT_LOST,
    LS_STREAM_LAYER_CONTACT_EVENTS, LS_STREAM_SECTION_BODY_GONE, LS_STREAM_SECTION_GEOMETRY, LS_STREAM_SECTION_JOINT_GONE,
    LS_STREAM_SECTION_SHAPE_GONE, LsStreamBreak, LsStreamEvent, LsStreamGeometry, LsStreamGone, LsStreamHeader, LsStreamPiece,
    LsStreamShape, LsStreamWorld, Wire,
};

use super::census::Census;
use super::meshes::{Meshes, Surface};
use super::records;
use crate::message::{Sections, clock, header};

/// Content of a message on the cold channel at most (bytes): about 200 bodies with a shape each.
pub(crate) const BLOCK: usize = 32 * 1024;

/// Published steps that a cycle takes at least. A reader that joins late waits for a second at most, of a world of 10,000 bodies.
const CYCLE_STEPS: usize = 60;

/// Messages of changes in one step at most; the rest follows with the next ones. A world that is filled at once has many.
const BLOCKS_A_STEP: u64 = 16;

/// Takes a message away: its header, and its content.
pub(crate) type Ship<'a> = &'a mut dyn FnMut(&mut LsStreamHeader, &[u8]);

/// What has yet to be told.
#[derive(Debug)]
enum News {
    Body(BodyId),
    Shape(ShapeId),
    Joint(JointId),
    Gone(u32, LsStreamGone),
    Event(LsStreamEvent),
    Break(LsStreamBreak),
    Piece(LsStreamPiece),
}

/// Where the cursor of a cycle is.
#[derive(Debug, Clone, Copy)]
enum Cursor {
    /// Bodies from this place on are still to be told, each with its shapes.
    Bodies(usize),
    /// Joints from this place on.
    Joints(usize),
}

/// What readers have been told, and what comes next.
#[derive(Debug)]
pub(crate) struct Cold {
    about: LsStreamWorld,
    session: u64,
    version: Option<[u64; 4]>,
    bodies: Census,
    shapes: Census,
    joints: Census,
    /// What is known of each body beside its state, by place: `LS_STREAM_BODY_` flags.
    pub flags: Vec<u32>,
    /// Rigid union of each body, by place; 0 for none.
    pub unions: Vec<u64>,
    unions_before: Vec<u64>,
    /// Places of the bodies that moved in the last step and in the one before it.
    moving: Vec<u32>,
    moving_before: Vec<u32>,
    knows_support: bool,
    meshes: Meshes,
    news: VecDeque<News>,
    cursor: Cursor,
    cycle: u64,
    block: Sections,
    block_flags: u32,
    shipped: u64,
}

impl Cold {
    pub(crate) fn new(about: LsStreamWorld, session: u64) -> Self {
        Self {
            about,
            session,
            version: None,
            bodies: Census::default(),
            shapes: Census::default(),
            joints: Census::default(),
            flags: Vec::new(),
            unions: Vec::new(),
            unions_before: Vec::new(),
            moving: Vec::new(),
            moving_before: Vec::new(),
            knows_support: false,
            meshes: Meshes::default(),
            news: VecDeque::new(),
            cursor: Cursor::Bodies(0),
            cycle: 0,
            block: Sections::default(),
            block_flags: 0,
            shipped: 0,
        }
    }

    /// Number of this life of the stream.
    pub(crate) fn session(&self) -> u64 {
        self.session
    }

    /// Tells the whole world at once, for whoever is there already.
    pub(crate) fn tell_all(&mut self, world: &World, ship: Ship<'_>) {
        self.look(world);
        self.news.clear();
        self.begin_cycle(world, ship);
        while !self.tell_next(world, ship) {}
        self.flush(world, ship);
        self.begin_cycle(world, ship);
    }

    /// Tells what changed in a step, and some more of the cycle.
    pub(crate) fn tell(&mut self, world: &World, ship: Ship<'_>) {
        self.look(world);
        self.note_events(world);
        self.note_rest(world);
        let start = self.shipped;
        while self.shipped - start < BLOCKS_A_STEP && self.tell_news(world, ship) {}
        self.tell_of_cycle(world, ship);
        self.flush(world, ship);
    }

    /// Finds out who has come and gone.
    fn look(&mut self, world: &World) {
        let version = Some(world.structure_version());
        if version != self.version {
            self.version = version;
            let Self { bodies, shapes, joints, news, flags, .. } = self;
            let step = world.step_count();
            let news = std::cell::RefCell::new(news);
            let gone = |kind: u32| {
                let news = &news;
                move |id: u64| news.borrow_mut().push_back(News::Gone(kind, LsStreamGone { id, step }))
            };
            joints.update(world.joints(), gone(LS_STREAM_SECTION_JOINT_GONE), |_| ());
            let of_bodies = world.bodies().flat_map(|body| world.body_shapes(body).unwrap_or_default().iter().copied());
            shapes.update(of_bodies, gone(LS_STREAM_SECTION_SHAPE_GONE), |_| ());
            bodies.update(world.bodies(), gone(LS_STREAM_SECTION_BODY_GONE), |body: BodyId| {
                flags.resize(flags.len().max(body.place() + 1), 0);
                flags[body.place()] = 0;
                news.borrow_mut().push_back(News::Body(body));
            });
            shapes.each_new(|shape| news.borrow_mut().push_back(News::Shape(shape)));
            joints.each_new(|joint| news.borrow_mut().push_back(News::Joint(joint)));
            self.knows_support = false;
            self.note_unions(world);
        }
        self.about.gravity = world.gravity().to_array();
        let on = world.supported_count().is_ok();
        if on != self.knows_support {
            self.knows_support = on;
            self.note_support(world);
        }
    }

    /// Takes down who is a member of which rigid union, which the union's lead names, and tells of those for whom that has changed.
    fn note_unions(&mut self, world: &World) {
        let Self { unions, unions_before, flags, news, bodies, .. } = self;
        std::mem::swap(unions, unions_before);
        unions.clear();
        unions.resize(flags.len(), 0);
        for union in world.unions() {
            for member in world.union_members(union.lead).into_iter().flatten() {
                unions[member.place()] = union.lead.to_bits();
            }
        }
        unions_before.resize(flags.len(), 0);
        for (place, _) in unions.iter().zip(&*unions_before).enumerate().filter(|(_, (now, before))| now != before) {
            news.extend(bodies.at::<BodyId>(place).map(News::Body));
        }
    }

    /// Takes the verdicts on all bodies into their flags.
    fn note_support(&mut self, world: &World) {
        for body in world.bodies() {
            let flags = &mut self.flags[body.place()];
            *flags &= !(LS_STREAM_BODY_SUPPORT_KNOWN | LS_STREAM_BODY_SUPPORTED);
            if let Ok(support) = world.support(body) {
                let supported = if support.verdict.is_supported() { LS_STREAM_BODY_SUPPORTED } else { 0 };
                *flags |= LS_STREAM_BODY_SUPPORT_KNOWN | supported;
            }
        }
    }

    /// Has bodies told of once more that moved in the step before and did not in this one: frames will not say where they came to
    /// rest, and who joins now has not seen those that did.
    fn note_rest(&mut self, world: &World) {
        let Self { moving, moving_before, bodies, news, .. } = self;
        std::mem::swap(moving, moving_before);
        moving.clear();
        moving.extend(world.moved().iter().map(|moved| moved.body.place() as u32));
        // Both are sorted.
        let mut still = moving.iter().peekable();
        for &place in moving_before.iter() {
            while still.next_if(|&&other| other < place).is_some() {}
            if still.peek() != Some(&&place) {
                news.extend(bodies.at::<BodyId>(place as usize).map(News::Body));
            }
        }
    }

    fn note_events(&mut self, world: &World) {
        let step = world.step_count();
        let Self { news, flags, .. } = self;
        for joint in world.broken() {
            let (event, record) = records::broken(joint);
            news.extend([News::Event(event), News::Break(record)]);
        }
        for split in world.splits() {
            for piece in &world.pieces()[split.pieces.0 as usize..split.pieces.1 as usize] {
                let user_word = world.user_word(split.first_body).unwrap_or(0);
                let (event, record) = records::piece(split, piece, user_word);
                news.extend([News::Event(event), News::Piece(record)]);
            }
        }
        for body in world.piece_bodies() {
            if let Some(flags) = flags.get_mut(body.place()) {
                *flags |= LS_STREAM_BODY_BROKEN;
            }
        }
        let mut note = |kind: u32, a: u64, b: u64, user_word: u64, values: [f32; 4]| {
            let event = LsStreamEvent { step, a, b, user_word, kind, values, ..LsStreamEvent::default() };
            news.push_back(News::Event(event));
        };
        for change in world.support_changes().unwrap_or_default() {
            if let Some(flags) = flags.get_mut(change.body.place()) {
                *flags |= LS_STREAM_BODY_SUPPORT_KNOWN;
                *flags = if change.supported { *flags | LS_STREAM_BODY_SUPPORTED } else { *flags & !LS_STREAM_BODY_SUPPORTED };
            }
            let kind = if change.supported { LS_STREAM_EVENT_SUPPORT_GAINED } else { LS_STREAM_EVENT_SUPPORT_LOST };
            note(kind, change.body.to_bits(), 0, change.user_word, [0.0; 4]);
        }
        for overload in world.overloaded() {
            let values = [overload.force, overload.torque, 0.0, 0.0];
            note(LS_STREAM_EVENT_OVERLOAD, overload.joint.to_bits(), 0, overload.user_word, values);
        }
        for body in world.quarantined() {
            note(LS_STREAM_EVENT_QUARANTINED, body.to_bits(), 0, world.user_word(*body).unwrap_or(0), [0.0; 4]);
        }
        if self.about.layers & LS_STREAM_LAYER_CONTACT_EVENTS != 0 {
            for pair in world.contact_began() {
                note(LS_STREAM_EVENT_CONTACT_BEGAN, pair.body_a.to_bits(), pair.body_b.to_bits(), 0, [0.0; 4]);
            }
            for pair in world.contact_ended() {
                note(LS_STREAM_EVENT_CONTACT_ENDED, pair.body_a.to_bits(), pair.body_b.to_bits(), 0, [0.0; 4]);
            }
        }
    }

    /// Tells the next piece of news; false if there are no more.
    fn tell_news(&mut self, world: &World, ship: Ship<'_>) -> bool {
        match self.news.pop_front() {
            Some(News::Body(body)) => self.tell_body(world, body, ship),
            Some(News::Shape(shape)) => self.tell_shape(world, shape, ship),
            Some(News::Joint(joint)) => self.tell_joint(world, joint, ship),
            Some(News::Gone(kind, gone)) => {
                self.make_room(world, size_of_val(&gone), ship);
                self.block.push_bytes(kind, bytemuck::bytes_of(&gone));
            }
            Some(News::Event(event)) => self.tell_plain(world, &event, ship),
            Some(News::Break(record)) => self.tell_plain(world, &record, ship),
            Some(News::Piece(record)) => self.tell_plain(world, &record, ship),
            None => return false,
        }
        true
    }

    /// Tells as much of the cycle as falls to one step.
    fn tell_of_cycle(&mut self, world: &World, ship: Ship<'_>) {
        let share = (self.bodies.count + self.joints.count).div_ceil(CYCLE_STEPS).max(1);
        let already = self.block.bytes.len();
        for _ in 0..share {
            if self.tell_next(world, ship) {
                self.flush(world, ship);
                self.begin_cycle(world, ship);
                break;
            }
            if self.block.bytes.len() > already.max(BLOCK / 2) {
                break;
            }
        }
    }

    /// Begins a cycle with a message of its own, so that what belongs to it is told by the numbers of messages.
    fn begin_cycle(&mut self, world: &World, ship: Ship<'_>) {
        self.flush(world, ship);
        self.meshes.forget_before(self.cycle);
        self.cycle += 1;
        self.cursor = Cursor::Bodies(0);
        self.block_flags |= LS_STREAM_CYCLE_BEGINS;
        self.block.push(&self.about);
    }

    /// Tells the next body, with its shapes, or the next joint of the cycle; true if that was all.
    fn tell_next(&mut self, world: &World, ship: Ship<'_>) -> bool {
        match self.cursor {
            Cursor::Bodies(place) => match self.bodies.at_or_after::<BodyId>(place) {
                Some((place, body)) => {
                    self.cursor = Cursor::Bodies(place + 1);
                    self.tell_body(world, body, ship);
                    for &shape in world.body_shapes(body).unwrap_or_default() {
                        self.tell_shape(world, shape, ship);
                    }
                    false
                }
                None => {
                    self.cursor = Cursor::Joints(0);
                    self.tell_next(world, ship)
                }
            },
            Cursor::Joints(place) => match self.joints.at_or_after::<JointId>(place) {
                Some((place, joint)) => {
                    self.cursor = Cursor::Joints(place + 1);
                    self.tell_joint(world, joint, ship);
                    false
                }
                None => {
                    self.block_flags |= LS_STREAM_CYCLE_ENDS;
                    true
                }
            },
        }
    }

    // An object that went after it was noted is not told: that it is gone has been noted too.

    fn tell_body(&mut self, world: &World, body: BodyId, ship: Ship<'_>) {
        let flags = self.flags.get(body.place()).copied().unwrap_or(0);
        let union = self.unions.get(body.place()).copied().unwrap_or(0);
        if let Ok(record) = records::body(world, body, flags, union) {
            self.tell_plain(world, &record, ship);
        }
    }

    fn tell_joint(&mut self, world: &World, joint: JointId, ship: Ship<'_>) {
        if let Ok(record) = records::joint(world, joint) {
            self.tell_plain(world, &record, ship);
        }
    }

    fn tell_shape(&mut self, world: &World, shape: ShapeId, ship: Ship<'_>) {
        let (Ok(def), Ok(body)) = (world.shape_def(shape), world.shape_body(shape)) else { return };
        records::shape(shape, body, &def, |geometry, record| {
            self.make_room(world, size_of_val(record), ship);
            self.block.push(record);
            let mut meshes = std::mem::take(&mut self.meshes);
            if let Some(surface) = meshes.surface(&def.shape, geometry, self.cycle) {
                self.tell_surface(world, record, surface, ship);
            }
            self.meshes = meshes;
        });
    }

    /// Tells the triangles of a form, as many to a message as fit.
    fn tell_surface(&mut self, world: &World, record: &LsStreamShape, surface: &Surface, ship: Ship<'_>) {
        let Surface { vertices, triangles } = surface;
        let (vertex_total, triangle_total) = (vertices.len() as u32, triangles.len() as u32);
        let (mut first_vertex, mut first_triangle) = (0, 0);
        while first_vertex < vertices.len() || first_triangle < triangles.len() {
            if self.block.len_with(size_of::<LsStreamGeometry>() + 12) > BLOCK {
                self.flush(world, ship);
            }
            let room = (BLOCK - self.block.len_with(size_of::<LsStreamGeometry>())) / 12;
            let vertex_count = room.min(vertices.len() - first_vertex);
            let triangle_count = (room - vertex_count).min(triangles.len() - first_triangle);
            let part = LsStreamGeometry {
                shape: record.shape,
                part: record.part,
                vertex_total,
                triangle_total,
                first_vertex: first_vertex as u32,
                vertex_count: vertex_count as u32,
                first_triangle: first_triangle as u32,
                triangle_count: triangle_count as u32,
                reserved: 0,
            };
            self.block.close();
            self.block.begin_bytes(LS_STREAM_SECTION_GEOMETRY);
            self.block.add_bytes(bytemuck::bytes_of(&part));
            for vertex in &vertices[first_vertex..first_vertex + vertex_count] {
                self.block.add_bytes(bytemuck::bytes_of(&vertex.to_array()));
            }
            self.block.add_bytes(bytemuck::cast_slice(&triangles[first_triangle..first_triangle + triangle_count]));
            self.block.close();
            first_vertex += vertex_count;
            first_triangle += triangle_count;
        }
    }

    fn tell_plain<T: Wire>(&mut self, world: &World, record: &T, ship: Ship<'_>) {
        self.make_room(world, size_of::<T>(), ship);
        self.block.push(record);
    }

    fn make_room(&mut self, world: &World, bytes: usize, ship: Ship<'_>) {
        if self.block.len_with(bytes) > BLOCK {
            self.flush(world, ship);
        }
    }

    /// Ships what has been collected.
    fn flush(&mut self, world: &World, ship: Ship<'_>) {
        if self.block.is_empty() && self.block_flags == 0 {
            return;
        }
        let mut header = LsStreamHeader {
            step: world.step_count(),
            time: world.time(),
            body_count: world.body_count() as u32,
            shape_count: world.shape_count() as u32,
            joint_count: world.joint_count() as u32,
            flags: std::mem::take(&mut self.block_flags),
            cycle: self.cycle,
            clock: clock(),
            ..header(LS_STREAM_CHANNEL_COLD, self.session)
        };
        let content = self.block.finish(&mut header);
        ship(&mut header, content);
        self.block.clear();
        self.shipped += 1;
    }
}
