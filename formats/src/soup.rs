//! Polygons as a file has them: nothing welded, nothing repaired.

/// What a scan file says: points, polygons over them, and the unit of the
/// numbers where the format declares one.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Soup {
    /// Positions, in the file's unit. May hold non-finite numbers and points
    /// that no polygon uses.
    pub points: Vec<[f64; 3]>,
    /// The polygons; every index is a valid index into `points`.
    pub polygons: Polygons,
    /// The unit that the format itself fixes (glTF: metres), else `None`.
    pub unit: Option<LengthUnit>,
    /// The mean colour of the points where they have one each (sRGB).
    pub colour: Option<[u8; 3]>,
}

/// Polygons of any size in two flat arrays.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Polygons {
    corners: Vec<u32>,
    ends: Vec<u32>,
}

impl Polygons {
    /// Appends one polygon, its corners in the file's order.
    pub fn push(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len() as u32);
    }

    /// How many polygons there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// How many corners the polygons have together.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// How many triangles the polygons make, each cut into a fan.
    pub fn triangle_count(&self) -> usize {
        self.iter().map(|corners| corners.len().saturating_sub(2)).sum()
    }

    /// Whether there is no polygon.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The corners of each polygon, in the file's order.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(a, &b)| &self.corners[a as usize..b as usize])
    }
}

/// A unit of length that a scan's numbers can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LengthUnit {
    /// Millimetres, the unit of everything after the readers.
    Millimetre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Inches of 25.4 mm.
    Inch,
}

impl LengthUnit {
    /// How many millimetres one unit is.
    pub fn in_mm(self) -> f64 {
        match self {
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Centimetre => 10.0,
            LengthUnit::Metre => 1000.0,
            LengthUnit::Inch => 25.4,
        }
    }

    /// The unit's abbreviation, as the command line spells it.
    pub fn symbol(self) -> &'static str {
        match self {
            LengthUnit::Millimetre => "mm",
            LengthUnit::Centimetre => "cm",
            LengthUnit::Metre => "m",
            LengthUnit::Inch => "in",
        }
    }
}
