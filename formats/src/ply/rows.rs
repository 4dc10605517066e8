//! The rows that ply-rs fills.

use ply_rs::ply::{BeginList, PropertyAccess, PropertyAccessResult};

/// A vertex: its position and its colour, if it has one.
pub(super) struct Position {
    pub(super) xyz: [f64; 3],
    pub(super) rgb: [f64; 3],
}

/// The names of the channels of a vertex colour.
pub(super) const CHANNELS: [&str; 3] = ["red", "green", "blue"];

impl Position {
    fn set(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        match name {
            "x" => self.xyz[0] = value,
            "y" => self.xyz[1] = value,
            "z" => self.xyz[2] = value,
            "red" => self.rgb[0] = value,
            "green" => self.rgb[1] = value,
            "blue" => self.rgb[2] = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

macro_rules! coordinates {
    ($($setter:ident: $scalar:ty),*) => {
        $(fn $setter(&mut self, name: &str, value: $scalar) -> PropertyAccessResult {
            self.set(name, f64::from(value))
        })*
    };
}
pub(super) use coordinates;

impl PropertyAccess for Position {
    fn new() -> Self {
        Position { xyz: [0.0; 3], rgb: [0.0; 3] }
    }

    coordinates!(set_char: i8, set_uchar: u8, set_short: i16, set_ushort: u16,
        set_int: i32, set_uint: u32, set_float: f32, set_double: f64);
}

/// The list of vertex numbers of a face or strip. Almost all files have the type `int`, which is
/// parsed in place. Only `uint` needs a second list.
pub(super) struct VertexNumbers {
    ints: Vec<i32>,
    uints: Vec<u32>,
}

impl VertexNumbers {
    pub(super) fn len(&self) -> usize {
        self.ints.len() + self.uints.len()
    }

    /// The vertex numbers of a triangle, if they are not negative.
    pub(super) fn triangle(&self) -> Option<[u32; 3]> {
        let &[a, b, c] = self.ints.as_slice() else { return None };
        Some([a.try_into().ok()?, b.try_into().ok()?, c.try_into().ok()?])
    }

    /// The vertex numbers, which may be negative.
    pub(super) fn indices(&self) -> impl Iterator<Item = i64> {
        let ints = self.ints.iter().map(|&i| i64::from(i));
        ints.chain(self.uints.iter().map(|&i| i64::from(i)))
    }
}

fn holds_corners(name: &str) -> bool {
    // The definition has renamed unwanted lists.
    matches!(name, "vertex_indices" | "vertex_index")
}

macro_rules! corner_lists {
    ($($setter:ident: $scalar:ty),*) => {
        $(fn $setter(&mut self, name: &str, value: Vec<$scalar>) -> PropertyAccessResult {
            if !holds_corners(name) {
                return PropertyAccessResult::Ignored;
            }
            self.ints = value.into_iter().map(i32::from).collect();
            PropertyAccessResult::Set
        })*
    };
}

impl PropertyAccess for VertexNumbers {
    fn new() -> Self {
        VertexNumbers { ints: Vec::new(), uints: Vec::new() }
    }

    fn begin_list_int(&mut self, name: &str, _len: usize) -> BeginList<'_, i32> {
        match holds_corners(name) {
            true => BeginList::Fill(&mut self.ints),
            false => BeginList::UseSetter,
        }
    }

    corner_lists!(set_list_char: i8, set_list_uchar: u8, set_list_short: i16,
        set_list_ushort: u16);

    fn set_list_uint(&mut self, name: &str, value: Vec<u32>) -> PropertyAccessResult {
        if !holds_corners(name) {
            return PropertyAccessResult::Ignored;
        }
        self.uints = value;
        PropertyAccessResult::Set
    }
}

/// A row of an element that is not needed.
pub(super) struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Ignored
    }
}
