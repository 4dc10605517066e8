//! The values of a binary PCD record.

/// The type of a value. All are little-endian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    F32,
    F64,
    I8,
    I16,
    I32,
    I64,
    U8,
    U16,
    U32,
    U64,
}

impl Kind {
    /// The type that the header calls by a letter and a number of bytes.
    pub(super) fn of(letter: &str, size: &str) -> Option<Kind> {
        match (letter, size) {
            ("F", "4") => Some(Kind::F32),
            ("F", "8") => Some(Kind::F64),
            ("I", "1") => Some(Kind::I8),
            ("I", "2") => Some(Kind::I16),
            ("I", "4") => Some(Kind::I32),
            ("I", "8") => Some(Kind::I64),
            ("U", "1") => Some(Kind::U8),
            ("U", "2") => Some(Kind::U16),
            ("U", "4") => Some(Kind::U32),
            ("U", "8") => Some(Kind::U64),
            _ => None,
        }
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::F32 | Kind::I32 | Kind::U32 => 4,
            Kind::F64 | Kind::I64 | Kind::U64 => 8,
        }
    }

    /// The number that `bytes` begin with. It is NaN if they are too few, which
    /// the readers do not let happen.
    pub(super) fn number(self, bytes: &[u8]) -> f64 {
        fn first<const N: usize>(bytes: &[u8]) -> Option<[u8; N]> {
            bytes.first_chunk().copied()
        }
        let number = match self {
            Kind::F32 => first(bytes).map(|b| f64::from(f32::from_le_bytes(b))),
            Kind::F64 => first(bytes).map(f64::from_le_bytes),
            Kind::I8 => first(bytes).map(|b| f64::from(i8::from_le_bytes(b))),
            Kind::I16 => first(bytes).map(|b| f64::from(i16::from_le_bytes(b))),
            Kind::I32 => first(bytes).map(|b| f64::from(i32::from_le_bytes(b))),
            Kind::I64 => first(bytes).map(|b| i64::from_le_bytes(b) as f64),
            Kind::U8 => first(bytes).map(|b| f64::from(u8::from_le_bytes(b))),
            Kind::U16 => first(bytes).map(|b| f64::from(u16::from_le_bytes(b))),
            Kind::U32 => first(bytes).map(|b| f64::from(u32::from_le_bytes(b))),
            Kind::U64 => first(bytes).map(|b| u64::from_le_bytes(b) as f64),
        };
        number.unwrap_or(f64::NAN)
    }
}

/// Where a value is in a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    pub(super) kind: Kind,
    /// The byte in a binary record at which it begins.
    pub(super) offset: usize,
    /// Which of the words of a line of text it is.
    pub(super) column: usize,
}

impl Slot {
    pub(super) fn number(&self, record: &[u8]) -> f64 {
        self.kind.number(record.get(self.offset..).unwrap_or_default())
    }
}
