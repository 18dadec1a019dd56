//! Names, offsets and sizes of all fields, for the document of the bytes and for a hash of them.

use std::mem::{offset_of, size_of};

use crate::*;

/// A field of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Bytes from the start of the record.
    pub offset: usize,
}

/// A record: its fields in order, without gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Name of the struct.
    pub name: &'static str,
    /// Its bytes.
    pub size: usize,
    /// Its fields.
    pub fields: &'static [Field],
    /// How many of them the schema began with; those behind were appended under the same number.
    pub first: usize,
}

/// `Record { fields }`, or `Record { fields } + { fields that came later }`.
macro_rules! records {
    ($($record:ident { $($field:ident),* $(,)? } $(+ { $($later:ident),* $(,)? })?)*) => {
        /// Every struct of the stream.
        pub const RECORDS: &[Record] = &[$(Record {
            name: stringify!($record),
            size: size_of::<$record>(),
            fields: &[
                $(Field { name: stringify!($field), offset: offset_of!($record, $field) },)*
                $($(Field { name: stringify!($later), offset: offset_of!($record, $later) },)*)?
            ],
            first: { const FIRST: &[&str] = &[$(stringify!($field)),*]; FIRST.len() },
        }),*];

        // A field that is not listed does not compile: these patterns name all of them.
        $(const _: fn($record) = |$record { $($field: _,)* $($($later: _,)*)? }| {};)*
    };
}

records! {
    LsStreamHeader {
        magic, schema, header_size, layout_hash, length, session, sequence, step, time, state_hash, content_hash, dropped,
        channel, section_count, body_count, shape_count, joint_count, flags, cycle, clock,
    }
    LsStreamSection { kind, stride, count, flags, length, reserved }
    LsStreamMotion {
        body, user_word, union_id, position, rotation, linear_velocity, angular_velocity, flags, reserved,
    }
    LsStreamContactPoint { position, separation, normal_force }
    LsStreamContact { body_a, body_b, normal, point_count, friction_force, reserved, points }
    LsStreamJointLoad { joint, force, torque, share, gap }
    LsStreamBound {
        near_joint, far_joint, near_point, far_point, distance, upper, lower, tension, kind, level, active, reserved,
    }
    LsStreamPlane { chain, point, normal, radius }
    LsStreamBody {
        body, user_word, union_id, step, position, rotation, linear_velocity, angular_velocity, flags, kind, mass, support,
        support_margin, support_load,
    }
    LsStreamShape {
        shape, body, user_word, kind, part, part_count, reserved, position, rotation, size, friction, restitution,
    }
    LsStreamJoint {
        joint, user_word, body_a, body_b, position_a, position_b, rotation_a, rotation_b, kind, flags, break_force,
        break_torque,
    }
    LsStreamGone { id, step }
    LsStreamGeometry {
        shape, part, vertex_total, triangle_total, first_vertex, vertex_count, first_triangle, triangle_count, reserved,
    }
    LsStreamWorld { name, process, gravity, substeps, iterations, support, layers, every }
    LsStreamEvent { step, a, b, user_word, kind, reserved, values }
    LsStreamBreak {} + {
        step, joint, user_word, body_a, body_b, point, force, torque, share, limit, cause, reserved,
    }
    LsStreamPiece {} + {
        step, of_body, first_body, center, linear_velocity, angular_velocity, mass, body_count, anchored, cut_loose,
    }
}

/// Hash of names and offsets of all fields that the schema began with (FNV-1a): differs between two builds that number their schema
/// alike and are not. What was appended since, fields at the end of records and kinds of records, does not count.
pub const LAYOUT_HASH: u64 = layout_hash(RECORDS);

const fn layout_hash(records: &[Record]) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325;
    let mut record = 0;
    while record < records.len() {
        let Record { name, size, fields, first } = records[record];
        if first > 0 {
            hash = mix_text(hash, name);
            hash = mix(hash, if first < fields.len() { fields[first].offset } else { size } as u64);
        }
        let mut field = 0;
        while field < first {
            hash = mix_text(hash, fields[field].name);
            hash = mix(hash, fields[field].offset as u64);
            field += 1;
        }
        record += 1;
    }
    hash
}

const fn mix_text(mut hash: u64, text: &str) -> u64 {
    let bytes = text.as_bytes();
    let mut index = 0;
    while index < bytes.len() {
        hash = mix(hash, bytes[index] as u64);
        index += 1;
    }
    hash
}

const fn mix(hash: u64, value: u64) -> u64 {
    (hash ^ value).wrapping_mul(0x0000_0100_0000_01b3)
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Field = Field { name: "a", offset: 0 };
    const B: Field = Field { name: "b", offset: 8 };
    const C: Field = Field { name: "c", offset: 16 };

    #[test]
    fn what_is_appended_leaves_the_hash_and_what_is_changed_does_not() {
        let record = |size, fields, first| Record { name: "R", size, fields, first };
        let hash = |records: &[Record]| layout_hash(records);
        let began = hash(&[record(16, &[A, B], 2)]);
        assert_eq!(hash(&[record(24, &[A, B, C], 2)]), began, "a field at the end");
        assert_eq!(hash(&[record(16, &[A, B], 2), Record { name: "S", ..record(8, &[A], 0) }]), began, "a record");
        assert_ne!(hash(&[record(16, &[B, A], 2)]), began, "another order");
        assert_ne!(hash(&[record(24, &[A, B], 2)]), began, "another size");
        assert_ne!(hash(&[record(16, &[A, Field { offset: 4, ..B }], 2)]), began, "another place");
        assert_ne!(hash(&[Record { name: "S", ..record(16, &[A, B], 2) }]), began, "another name");
    }
}
