//! The polygons of a file without any welding or repair (a polygon soup).

/// The content of a scan file: points, polygons, and the unit of length if the format declares one.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Soup {
    /// The points in the unit of the file. They may have non-finite coordinates, and some may not
    /// be used by any polygon.
    pub points: Vec<[f64; 3]>,
    /// The polygons. Every index is a valid index into `points`.
    pub polygons: Polygons,
    /// The unit that the format itself defines, for example metres for glTF, or that a comment of the file
    /// names. `None` if neither does.
    pub unit: Option<LengthUnit>,
    /// The comment that names the unit, if only a comment does.
    pub unit_comment: Option<String>,
    /// The mean colour of the points (sRGB). `None` if not every point has a colour.
    pub colour: Option<[u8; 3]>,
}

/// Polygons with any numbers of corners in two flat arrays.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Polygons {
    corners: Vec<u32>,
    ends: Vec<u32>,
}

impl Polygons {
    /// Appends one polygon. Its corners are in the order of the file.
    pub fn push(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len() as u32);
    }

    /// Turns all polygons over. The first corner of each stays the first.
    pub(crate) fn turn_over(&mut self) {
        let mut start = 0;
        for &end in &self.ends {
            if let Some(rest) = self.corners.get_mut(start + 1..end as usize) {
                rest.reverse();
            }
            start = end as usize;
        }
    }

    /// The number of polygons.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// The number of corners of all polygons.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// The number of triangles if each polygon is divided into a fan.
    pub fn triangle_count(&self) -> usize {
        self.iter().map(|corners| corners.len().saturating_sub(2)).sum()
    }

    /// Whether there is no polygon.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The corners of each polygon in the order of the file.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(a, &b)| &self.corners[a as usize..b as usize])
    }
}

/// The unit of length of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LengthUnit {
    /// Millimetres. All stages after the readers use this unit.
    Millimetre,
    /// Micrometres.
    Micrometre,
    /// Centimetres.
    Centimetre,
    /// Metres.
    Metre,
    /// Inches of 25.4 mm.
    Inch,
    /// International feet of 304.8 mm.
    Foot,
    /// US survey feet of 1200/3937 m.
    UsSurveyFoot,
}

impl LengthUnit {
    /// The length of one unit in millimetres.
    pub fn in_mm(self) -> f64 {
        match self {
            LengthUnit::Micrometre => 1e-3,
            LengthUnit::Millimetre => 1.0,
            LengthUnit::Centimetre => 10.0,
            LengthUnit::Metre => 1000.0,
            LengthUnit::Inch => 25.4,
            LengthUnit::Foot => 304.8,
            LengthUnit::UsSurveyFoot => 1_200_000.0 / 3937.0,
        }
    }

    /// The abbreviation of the unit, as in reports.
    pub fn symbol(self) -> &'static str {
        match self {
            LengthUnit::Micrometre => "um",
            LengthUnit::Millimetre => "mm",
            LengthUnit::Centimetre => "cm",
            LengthUnit::Metre => "m",
            LengthUnit::Inch => "in",
            LengthUnit::Foot => "ft",
            LengthUnit::UsSurveyFoot => "ftUS",
        }
    }

    /// The unit with this abbreviation. `None` if it is none of them.
    pub(crate) fn by_symbol(symbol: &str) -> Option<LengthUnit> {
        let all = [
            LengthUnit::Millimetre,
            LengthUnit::Micrometre,
            LengthUnit::Centimetre,
            LengthUnit::Metre,
            LengthUnit::Inch,
            LengthUnit::Foot,
            LengthUnit::UsSurveyFoot,
        ];
        all.into_iter().find(|unit| unit.symbol() == symbol)
    }
}
