//! Handles: 64 bits each, a C struct type per kind.

use ls_core::{BodyId, Handle, JointId, ShapeId};

/// Names a world. Passed by value; any value is safe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsWorld {
    /// Opaque bits, zero for none; they may be stored, compared, and handed back later.
    pub id: u64,
}

/// Names a body of one world. Passed by value; any value is safe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsBody {
    /// Opaque bits, zero for none; they may be stored, compared, and handed back later.
    pub id: u64,
}

/// Names a shape on a body of one world. Passed by value; any value is safe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsShape {
    /// Opaque bits, zero for none; they may be stored, compared, and handed back later.
    pub id: u64,
}

/// Names a joint of one world. Passed by value; any value is safe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LsJoint {
    /// Opaque bits, zero for none; they may be stored, compared, and handed back later.
    pub id: u64,
}

impl LsBody {
    pub(crate) const NULL: Self = Self { id: 0 };
}

macro_rules! same_bits {
    ($($name:ident = $core:ident),*) => {$(
        impl From<$name> for $core {
            fn from(handle: $name) -> Self {
                Self::from_bits(handle.id)
            }
        }

        impl From<$core> for $name {
            fn from(handle: $core) -> Self {
                Self { id: handle.to_bits() }
            }
        }
    )*};
}

same_bits!(LsBody = BodyId, LsShape = ShapeId, LsJoint = JointId);
