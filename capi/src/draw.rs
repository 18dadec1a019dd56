//! Drawing what a world holds: lines, triangles and texts through callbacks of the host.

use std::ffi::{CString, c_char, c_void};

use ls_core::glam::DVec3;
use ls_core::{Color, DebugDraw, DrawLayers, DrawOptions};

use crate::access::read;
use crate::boundary::call;
use crate::callback;
use crate::enums;
use crate::float_environment::as_host;
use crate::handle::LsWorld;
use crate::pointer::host;
use crate::result::{LsResult, Outcome};
use crate::sized::{self, Definition, SizedOut, Versioned};

/// Layer: outlines of shapes: static grey, kinematic blue, awake orange, held where they are yellow, asleep dim, sensors green,
/// quarantined red.
pub const LS_DRAW_SHAPES: u32 = 1;
/// Layer: the same as triangles.
pub const LS_DRAW_SURFACES: u32 = 2;
/// Layer: contact points with their normal from A to B: white where they press, grey where they do not.
pub const LS_DRAW_CONTACTS: u32 = 4;
/// Layer: forces of contacts on B, along the normal red and of friction orange.
pub const LS_DRAW_CONTACT_FORCES: u32 = 8;
/// Layer: joints: lines from both centres of mass to the joint points, and both joint frames.
pub const LS_DRAW_JOINTS: u32 = 16;
/// Layer: limits of joints, and where the joint is between them.
pub const LS_DRAW_JOINT_LIMITS: u32 = 32;
/// Layer: force of each joint as a line on B and as a text (N), coloured by its share of the break force.
pub const LS_DRAW_JOINT_LOADS: u32 = 64;
/// Layer: a box around each island awake, in a colour of its own, and around each asleep, dim; of those with joints how they are solved.
pub const LS_DRAW_ISLANDS: u32 = 128;
/// Layer: long-range bounds: taut ones red with their tension (N), slack ones green with what is left (m).
pub const LS_DRAW_BOUNDS: u32 = 256;
/// Layer: supporting contacts, the hull they span and the centre of mass above it, coloured by verdict; while the support
/// analysis is on.
pub const LS_DRAW_SUPPORT: u32 = 512;
/// Layer: centres of mass with principal axes.
pub const LS_DRAW_MASS: u32 = 1024;
/// Layer: velocities of centres of mass.
pub const LS_DRAW_VELOCITIES: u32 = 2048;
/// Layer: boxes that the broad phase keeps.
pub const LS_DRAW_BOXES: u32 = 4096;
/// Layer: planes of hinge chains: a square through them with its normal, and how far each body's centre of mass is off it, which
/// the chain keeps.
pub const LS_DRAW_PLANES: u32 = 8192;
/// Layer: unions: a line from the centre of mass of each to every body of it, and their number.
pub const LS_DRAW_UNIONS: u32 = 16384;

// The bits are those of the core.
const _: () = {
    const fn same(bit: u32, layer: DrawLayers) {
        assert!(bit == layer.bits());
    }
    same(LS_DRAW_SHAPES, DrawLayers::SHAPES);
    same(LS_DRAW_SURFACES, DrawLayers::SURFACES);
    same(LS_DRAW_CONTACTS, DrawLayers::CONTACTS);
    same(LS_DRAW_CONTACT_FORCES, DrawLayers::CONTACT_FORCES);
    same(LS_DRAW_JOINTS, DrawLayers::JOINTS);
    same(LS_DRAW_JOINT_LIMITS, DrawLayers::JOINT_LIMITS);
    same(LS_DRAW_JOINT_LOADS, DrawLayers::JOINT_LOADS);
    same(LS_DRAW_ISLANDS, DrawLayers::ISLANDS);
    same(LS_DRAW_BOUNDS, DrawLayers::BOUNDS);
    same(LS_DRAW_SUPPORT, DrawLayers::SUPPORT);
    same(LS_DRAW_MASS, DrawLayers::MASS);
    same(LS_DRAW_VELOCITIES, DrawLayers::VELOCITIES);
    same(LS_DRAW_BOXES, DrawLayers::BOXES);
    same(LS_DRAW_PLANES, DrawLayers::PLANES);
    same(LS_DRAW_UNIONS, DrawLayers::UNIONS);
};

/// Draws a line; given in an LsDraw.
///
/// The drawing callbacks are called on the thread that calls ls_world_draw, under its own floating-point settings. They must
/// return normally (no exception, no longjmp). Inside them reads work, edits of any world return LS_ERROR_WORLD_LOCKED.
/// @param from   three doubles (m), valid during the call
/// @param to     three doubles (m), valid during the call
/// @param color  0xRRGGBB
/// @param user   as given in the LsDraw
pub type LsDrawLineCallback = Option<unsafe extern "C" fn(from: *const f64, to: *const f64, color: u32, user: *mut c_void)>;

/// Draws a triangle, counter-clockwise seen from outside where it has an outside; given in an LsDraw, see LsDrawLineCallback.
/// @param corners  nine doubles, three a corner (m), valid during the call
/// @param color    0xRRGGBB
/// @param user     as given in the LsDraw
pub type LsDrawTriangleCallback = Option<unsafe extern "C" fn(corners: *const f64, color: u32, user: *mut c_void)>;

/// Draws a short text; given in an LsDraw, see LsDrawLineCallback.
/// @param at     three doubles (m), valid during the call
/// @param text   UTF-8, valid during the call
/// @param color  0xRRGGBB
/// @param user   as given in the LsDraw
pub type LsDrawTextCallback = Option<unsafe extern "C" fn(at: *const f64, text: *const c_char, color: u32, user: *mut c_void)>;

/// What is drawn, how, and by whom. Fill it with ls_draw_init first.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct LsDraw {
    /// Size of this struct in the host, set by ls_draw_init.
    pub struct_size: u32,
    /// Bit set of LS_DRAW_ constants; default LS_DRAW_SHAPES | LS_DRAW_JOINTS.
    pub layers: u32,
    /// Draws lines; NULL, the default, for none.
    pub line: LsDrawLineCallback,
    /// Draws triangles; NULL, the default, for none.
    pub triangle: LsDrawTriangleCallback,
    /// Draws texts; NULL, the default, for none.
    pub text: LsDrawTextCallback,
    /// Handed back to the callbacks; default NULL.
    pub user: *mut c_void,
    /// Length of a force's line (m/N), >= 0; default 0.001.
    pub force_scale: f32,
    /// Length of a velocity's line (s), >= 0; default 0.1.
    pub velocity_scale: f32,
    /// Length of the axes of a joint frame and size of a contact point's cross (m), > 0; default 0.1.
    pub mark_size: f32,
    /// Not 0: only what lies within radius of center is drawn; default 0.
    pub only_near: u32,
    /// Middle of what is drawn (m); default 0, 0, 0.
    pub center: [f64; 3],
    /// How far from the middle things are drawn (m), >= 0; default 0.
    pub radius: f64,
}

// SAFETY: numbers and pointers without padding.
unsafe impl Versioned for LsDraw {
    const SIZES: &'static [usize] = &[size_of::<Self>()];
}

// SAFETY: begins with struct_size.
unsafe impl Definition for LsDraw {}

impl Default for LsDraw {
    fn default() -> Self {
        let DrawOptions { layers, force_scale, velocity_scale, mark_size, within: _ } = DrawOptions::default();
        Self {
            struct_size: size_of::<Self>() as u32,
            layers: layers.bits(),
            line: None,
            triangle: None,
            text: None,
            user: std::ptr::null_mut(),
            force_scale,
            velocity_scale,
            mark_size,
            only_near: 0,
            center: [0.0; 3],
            radius: 0.0,
        }
    }
}

impl TryFrom<&LsDraw> for DrawOptions {
    type Error = crate::result::Failure;
    fn try_from(draw: &LsDraw) -> Outcome<Self> {
        Ok(Self {
            layers: DrawLayers::from_bits(draw.layers).ok_or_else(|| enums::unknown("layers"))?,
            force_scale: draw.force_scale,
            velocity_scale: draw.velocity_scale,
            mark_size: draw.mark_size,
            within: (draw.only_near != 0).then_some((DVec3::from_array(draw.center), draw.radius)),
        })
    }
}

/// Fills a drawing order with defaults: outlines and joints, and no callbacks.
///
/// @param draw  filled on LS_OK
/// @param size  sizeof *draw as the host knows it
/// @return LS_OK, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE
/// Threads: any thread at any time. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_draw_init(draw: *mut LsDraw, size: usize) -> LsResult {
    call("ls_draw_init", || host!(SizedOut::new, draw, size).write_definition(&LsDraw::default()))
}

/// Draws what a world holds now, layer by layer, through the callbacks of the drawing order. Nothing is changed or kept.
///
/// @param world  the world; any value is safe
/// @param draw   filled by ls_draw_init and changed as wanted; read during the call
/// @return LS_OK, a world error, LS_ERROR_NULL_ARGUMENT, LS_ERROR_STRUCT_SIZE, LS_ERROR_INVALID_ENUM, LS_ERROR_NOT_FINITE,
///         LS_ERROR_OUT_OF_RANGE
/// Threads: read. Callbacks: allowed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn ls_world_draw(world: LsWorld, draw: *const LsDraw) -> LsResult {
    call("ls_world_draw", || {
        let draw = host!(sized::read, draw);
        let options = (&draw).try_into()?;
        read(world, |world| {
            let _inside = callback::enter_any();
            Ok(world.draw(&options, &mut Host(&draw))?)
        })
    })
}

struct Host<'a>(&'a LsDraw);

impl DebugDraw for Host<'_> {
    fn line(&mut self, from: DVec3, to: DVec3, color: Color) {
        if let Some(line) = self.0.line {
            // SAFETY: the host promised a function of this type that accepts its own pointer.
            as_host(|| unsafe { line(from.to_array().as_ptr(), to.to_array().as_ptr(), color.0, self.0.user) });
        }
    }

    fn triangle(&mut self, corners: [DVec3; 3], color: Color) {
        if let Some(triangle) = self.0.triangle {
            let corners = corners.map(|corner| corner.to_array());
            // SAFETY: as above.
            as_host(|| unsafe { triangle(corners.as_flattened().as_ptr(), color.0, self.0.user) });
        }
    }

    fn text(&mut self, at: DVec3, text: &str, color: Color) {
        // What the library draws has no zero byte in it.
        if let (Some(draw), Ok(text)) = (self.0.text, CString::new(text)) {
            // SAFETY: as above.
            as_host(|| unsafe { draw(at.to_array().as_ptr(), text.as_ptr(), color.0, self.0.user) });
        }
    }
}
