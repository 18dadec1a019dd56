//! Convex parts of shapes as queries see them: in double precision, in world axes about a point near the query.

use glam::{DMat3, DQuat, DVec3, Quat, Vec3};

use crate::hull::Hull;
use crate::shape::Geometry;

/// Half extent of the box that stands for a half-space (m): more than any two coordinates differ by.
const ENDLESS: f64 = 1.0e10;

/// The form of a part, less its rounding, in its own frame (m).
#[derive(Debug, Clone, Copy)]
pub(super) enum PartForm<'a> {
    /// The centre of a ball.
    Point,
    /// The axis of a capsule, along y.
    Segment {
        half_height: f64,
    },
    Box {
        half_extents: DVec3,
    },
    Cylinder {
        half_height: f64,
        radius: f64,
    },
    Cone {
        half_height: f64,
        radius: f64,
    },
    Hull(&'a Hull),
    /// In the frame of the query.
    Triangle([DVec3; 3]),
    HalfSpace {
        normal: DVec3,
    },
}

/// Where a part is: its origin (m) in the frame of the query, and its rotation.
#[derive(Debug, Clone, Copy)]
pub(super) struct PartPose {
    pub origin: DVec3,
    pub axes: DMat3,
}

impl PartPose {
    pub(super) fn new(origin: DVec3, rotation: Quat) -> Self {
        // Single-precision rotations are of unit length to 1e-7 only.
        Self { origin, axes: DMat3::from_quat(rotation.as_dquat().normalize()) }
    }

    pub(super) fn to_local(self, point: DVec3) -> DVec3 {
        self.axes.transpose() * (point - self.origin)
    }

    pub(super) fn to_frame(self, point: DVec3) -> DVec3 {
        self.axes * point + self.origin
    }

    pub(super) fn then(self, position: Vec3, rotation: Quat) -> Self {
        let inner = Self::new(position.as_dvec3(), rotation);
        Self { origin: self.to_frame(inner.origin), axes: self.axes * inner.axes }
    }
}

/// A convex part of a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct ConvexPart<'a> {
    pub form: PartForm<'a>,
    pub place: PartPose,
    /// Radius around the form (m).
    pub rounding: f64,
    /// Number of the part of a compound.
    pub part: Option<u32>,
    /// Number of the triangle of a mesh or height field.
    pub triangle: Option<u32>,
}

impl<'a> ConvexPart<'a> {
    /// The part that a form is; none for a form of several.
    pub(super) fn whole(geometry: &Geometry, hull: Option<&'a Hull>, place: PartPose) -> Option<Self> {
        let (form, rounding) = match *geometry {
            Geometry::Ball { radius } => (PartForm::Point, f64::from(radius)),
            Geometry::Capsule { half_height, radius } => {
                (PartForm::Segment { half_height: f64::from(half_height) }, f64::from(radius))
            }
            Geometry::Box { half_extents } => (PartForm::Box { half_extents: half_extents.as_dvec3() }, 0.0),
            Geometry::Cylinder { half_height, radius } => {
                (PartForm::Cylinder { half_height: f64::from(half_height), radius: f64::from(radius) }, 0.0)
            }
            Geometry::Cone { half_height, radius } => {
                (PartForm::Cone { half_height: f64::from(half_height), radius: f64::from(radius) }, 0.0)
            }
            Geometry::ConvexHull { .. } => (PartForm::Hull(hull?), 0.0),
            Geometry::HalfSpace { normal } => (PartForm::HalfSpace { normal: normal.as_dvec3().normalize() }, 0.0),
            Geometry::TriangleMesh { .. } | Geometry::HeightField { .. } | Geometry::Compound { .. } => return None,
        };
        Some(Self { form, place, rounding, part: None, triangle: None })
    }

    /// Part `number` of a compound that is at `place`.
    pub(super) fn of_compound(
        (pose, geometry): &(crate::shape::LocalPose, Geometry),
        hull: Option<&'a Hull>,
        place: PartPose,
        number: u32,
    ) -> Option<Self> {
        let part = Self::whole(geometry, hull, place.then(pose.position, pose.rotation))?;
        Some(Self { part: Some(number), ..part })
    }

    /// A triangle with these corners in the frame of the query.
    pub(super) fn triangle(corners: [DVec3; 3], number: u32) -> Self {
        let place = PartPose { origin: (corners[0] + corners[1] + corners[2]) / 3.0, axes: DMat3::IDENTITY };
        Self { form: PartForm::Triangle(corners), place, rounding: 0.0, part: None, triangle: Some(number) }
    }

    /// The point of the form, less its rounding, that is farthest along `direction`. A half-space has no such point.
    pub(super) fn support(&self, direction: DVec3) -> DVec3 {
        if let PartForm::Triangle([a, b, c]) = self.form {
            let (p, q, r) = (a.dot(direction), b.dot(direction), c.dot(direction));
            return if p >= q && p >= r {
                a
            } else if q >= r {
                b
            } else {
                c
            };
        }
        let local = self.place.axes.transpose() * direction;
        let rim = |radius: f64, y: f64| {
            let across = DVec3::new(local.x, 0.0, local.z).try_normalize().unwrap_or(DVec3::ZERO);
            DVec3::new(across.x * radius, y, across.z * radius)
        };
        let point = match self.form {
            PartForm::Point | PartForm::HalfSpace { .. } | PartForm::Triangle(_) => return self.place.origin,
            PartForm::Segment { half_height } => DVec3::new(0.0, half_height.copysign(local.y), 0.0),
            PartForm::Box { half_extents } => half_extents.copysign(local),
            PartForm::Cylinder { half_height, radius } => rim(radius, half_height.copysign(local.y)),
            PartForm::Cone { half_height, radius } => {
                let (base, tip) = (rim(radius, -half_height), DVec3::new(0.0, half_height, 0.0));
                if base.dot(local) > tip.dot(local) { base } else { tip }
            }
            PartForm::Hull(hull) => hull.points()[hull.farthest(local) as usize].as_dvec3(),
        };
        self.place.to_frame(point)
    }

    /// Radius of a ball about the part's origin that holds it (m); infinite for a half-space.
    pub(super) fn reach(&self) -> f64 {
        let form = match self.form {
            PartForm::Point => 0.0,
            PartForm::Segment { half_height } => half_height,
            PartForm::Box { half_extents } => half_extents.length(),
            PartForm::Cylinder { half_height, radius } | PartForm::Cone { half_height, radius } => {
                libm::hypot(half_height, radius)
            }
            PartForm::Hull(hull) => hull.reach(),
            PartForm::Triangle(corners) => corners.iter().map(|corner| corner.distance(self.place.origin)).fold(0.0, f64::max),
            PartForm::HalfSpace { .. } => f64::INFINITY,
        };
        form + self.rounding
    }

    /// Least radius of what is round, else the reach (m).
    pub(super) fn finest(&self) -> f64 {
        match self.form {
            PartForm::Point | PartForm::Segment { .. } => self.rounding,
            PartForm::Cylinder { radius, .. } | PartForm::Cone { radius, .. } => radius,
            _ => self.reach(),
        }
    }

    /// The box around the part in the frame of the query: its least and greatest corner (m).
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        if matches!(self.form, PartForm::HalfSpace { .. }) {
            return (DVec3::splat(-ENDLESS), DVec3::splat(ENDLESS));
        }
        let farthest = |direction: DVec3| self.support(direction).dot(direction) + self.rounding;
        let toward =
            |sign: f64| sign * DVec3::new(farthest(DVec3::X * sign), farthest(DVec3::Y * sign), farthest(DVec3::Z * sign));
        (toward(-1.0), toward(1.0))
    }

    /// Outward normal of the flat face that faces a direction most, in the frame of the query; none without flat faces.
    pub(super) fn face_toward(&self, direction: DVec3) -> Option<DVec3> {
        if let PartForm::Triangle([a, b, c]) = self.form {
            let normal = (b - a).cross(c - a).try_normalize()?;
            return Some(normal * 1.0_f64.copysign(normal.dot(direction)));
        }
        let local = self.place.axes.transpose() * direction;
        let normal = match self.form {
            PartForm::Box { .. } => {
                let facing = local.abs();
                let axis = (1..3).fold(0, |best, i| if facing[i] > facing[best] { i } else { best });
                let mut normal = DVec3::ZERO;
                normal[axis] = 1.0_f64.copysign(local[axis]);
                normal
            }
            PartForm::Cylinder { .. } => DVec3::Y * 1.0_f64.copysign(local.y),
            PartForm::Cone { .. } => DVec3::NEG_Y,
            PartForm::Hull(hull) => {
                let facing = |plane: &(DVec3, f64)| plane.0.dot(local);
                hull.planes().iter().reduce(|best, plane| if facing(plane) > facing(best) { plane } else { best })?.0
            }
            _ => return None,
        };
        Some(self.place.axes * normal)
    }

    /// How far a point is outside the form, less its rounding: past one of its faces, or round it (m). Negative inside; of a
    /// triangle, how far past its edges as its normal sees them.
    pub(super) fn outside(&self, point: DVec3) -> f64 {
        if let PartForm::Triangle([a, b, c]) = self.form {
            let normal = (b - a).cross(c - a);
            let past = |from: DVec3, to: DVec3| (point - from).dot((to - from).cross(normal).normalize_or_zero());
            return past(a, b).max(past(b, c)).max(past(c, a));
        }
        let p = self.place.to_local(point);
        let across = libm::hypot(p.x, p.z);
        match self.form {
            PartForm::Point | PartForm::Triangle(_) => p.length(),
            PartForm::Segment { half_height } => (p - DVec3::Y * p.y.clamp(-half_height, half_height)).length(),
            PartForm::Box { half_extents } => (p.abs() - half_extents).max_element(),
            PartForm::Cylinder { half_height, radius } => (p.y.abs() - half_height).max(across - radius),
            PartForm::Cone { half_height, radius } => {
                let steepness = radius / (2.0 * half_height);
                (-half_height - p.y).max((across - steepness * (half_height - p.y)) / libm::hypot(1.0, steepness))
            }
            PartForm::Hull(hull) => hull.planes().iter().map(|(normal, offset)| normal.dot(p) - offset).fold(f64::MIN, f64::max),
            PartForm::HalfSpace { normal } => normal.dot(p),
        }
    }

    /// How deep a point inside the form is, less its rounding (m), and the outward normal of the nearest place of its surface, in the frame of
    /// the query; none of forms without an inside.
    pub(super) fn way_out(&self, point: DVec3) -> Option<(f64, DVec3)> {
        let p = self.place.to_local(point);
        let around = || DVec3::new(p.x, 0.0, p.z).try_normalize().unwrap_or(DVec3::X);
        let nearer = |a: (f64, DVec3), b: (f64, DVec3)| if b.0 < a.0 { b } else { a };
        let (depth, normal) = match self.form {
            PartForm::Box { half_extents } => {
                let axis = |i: usize| (half_extents[i] - p[i].abs(), DVec3::AXES[i] * 1.0_f64.copysign(p[i]));
                nearer(nearer(axis(0), axis(1)), axis(2))
            }
            PartForm::Cylinder { half_height, radius } => {
                let end = (half_height - p.y.abs(), DVec3::Y * 1.0_f64.copysign(p.y));
                nearer(end, (radius - libm::hypot(p.x, p.z), around()))
            }
            PartForm::Cone { half_height, radius } => {
                let steepness = radius / (2.0 * half_height);
                let slant = libm::hypot(1.0, steepness);
                let side = (steepness * (half_height - p.y) - libm::hypot(p.x, p.z)) / slant;
                nearer((half_height + p.y, DVec3::NEG_Y), (side, (around() + DVec3::Y * steepness) / slant))
            }
            PartForm::Hull(hull) => {
                hull.planes().iter().map(|&(normal, offset)| (offset - normal.dot(p), normal)).reduce(nearer)?
            }
            PartForm::Point | PartForm::Segment { .. } | PartForm::Triangle(_) | PartForm::HalfSpace { .. } => return None,
        };
        Some((depth, self.place.axes * normal))
    }

    /// Outward normal of a half-space in the frame of the query; none of any other form.
    pub(super) fn half_space(&self) -> Option<DVec3> {
        match self.form {
            PartForm::HalfSpace { normal } => Some(self.place.axes * normal),
            _ => None,
        }
    }

    /// The same part, moved (m) and then turned about a point.
    pub(super) fn moved(&self, path: DVec3, turn: DQuat, about: DVec3) -> Self {
        let turn = DMat3::from_quat(turn);
        let to = |point: DVec3| turn * (point - about) + about + path;
        let form = if let PartForm::Triangle(corners) = self.form { PartForm::Triangle(corners.map(to)) } else { self.form };
        let place = PartPose { origin: to(self.place.origin), axes: turn * self.place.axes };
        Self { form, place, ..*self }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A part of a form without rounding, with its axes in the frame of the query.
    pub(in super::super) fn part(form: PartForm<'static>, origin: DVec3, [x, y, z]: [DVec3; 3]) -> ConvexPart<'static> {
        ConvexPart {
            form,
            place: PartPose { origin, axes: DMat3::from_cols(x, y, z) },
            rounding: 0.0,
            part: None,
            triangle: None,
        }
    }
}
