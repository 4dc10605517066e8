//! The fields of a point in an E57 file, by the names that ASTM E2807 gives them. The normals
//! are those of the extension of libE57.

use ::e57::{Record, RecordDataType, RecordName};

/// Where the wanted values are in a point, with their types.
#[derive(Default)]
pub(super) struct Fields {
    /// Whether the values of a field are looked at.
    wanted: Vec<bool>,
    cartesian: Option<[usize; 3]>,
    cartesian_state: Option<usize>,
    spherical: Option<[usize; 3]>,
    spherical_state: Option<usize>,
    normal: Option<[usize; 3]>,
    intensity: Option<usize>,
    intensity_state: Option<usize>,
    colour: Option<usize>,
    colour_state: Option<usize>,
    row_column: Option<[usize; 2]>,
    /// The names of the fields that are not read.
    pub(super) others: Vec<String>,
}

impl Fields {
    pub(super) fn of(prototype: &[Record]) -> Fields {
        let find = |name: &RecordName| prototype.iter().position(|record| record.name == *name);
        let three = |[x, y, z]: [RecordName; 3]| Some([find(&x)?, find(&y)?, find(&z)?]);
        let extension = |wanted: &str| {
            prototype.iter().position(|record| match &record.name {
                RecordName::Unknown { name, .. } => name == wanted,
                _ => false,
            })
        };
        let [nx, ny, nz] = NORMAL.map(extension);
        let row_column = [RecordName::RowIndex, RecordName::ColumnIndex].map(|name| find(&name));
        Fields {
            wanted: prototype.iter().map(|record| is_wanted(&record.name)).collect(),
            cartesian: three(CARTESIAN),
            cartesian_state: find(&RecordName::CartesianInvalidState),
            spherical: three(SPHERICAL),
            spherical_state: find(&RecordName::SphericalInvalidState),
            normal: nx.zip(ny).zip(nz).map(|((x, y), z)| [x, y, z]),
            intensity: find(&RecordName::Intensity),
            intensity_state: find(&RecordName::IsIntensityInvalid),
            colour: find(&RecordName::ColorRed),
            colour_state: find(&RecordName::IsColorInvalid),
            row_column: row_column[0].zip(row_column[1]).map(|(row, column)| [row, column]),
            others: prototype.iter().filter_map(|record| other(&record.name)).collect(),
        }
    }

    /// Whether the values of field number `field` are looked at.
    pub(super) fn is_wanted(&self, field: usize) -> bool {
        self.wanted.get(field).copied().unwrap_or(false)
    }

    pub(super) fn has_position(&self) -> bool {
        self.cartesian.is_some() || self.spherical.is_some()
    }

    /// Whether the scan has ranges and angles only.
    pub(super) fn is_spherical(&self) -> bool {
        self.cartesian.is_none() && self.spherical.is_some()
    }

    pub(super) fn has_normals(&self) -> bool {
        self.normal.is_some()
    }

    pub(super) fn has_intensity(&self) -> bool {
        self.intensity.is_some()
    }

    pub(super) fn has_grid(&self) -> bool {
        self.row_column.is_some()
    }
}

const CARTESIAN: [RecordName; 3] =
    [RecordName::CartesianX, RecordName::CartesianY, RecordName::CartesianZ];

const SPHERICAL: [RecordName; 3] =
    [RecordName::SphericalRange, RecordName::SphericalAzimuth, RecordName::SphericalElevation];

const NORMAL: [&str; 3] = ["normalX", "normalY", "normalZ"];

/// Whether the values of a field are looked at. A colour only has to be there.
fn is_wanted(name: &RecordName) -> bool {
    let is_colour =
        [RecordName::ColorRed, RecordName::ColorGreen, RecordName::ColorBlue].contains(name);
    !is_colour && other(name).is_none()
}

/// The name of a field that is not read.
fn other(name: &RecordName) -> Option<String> {
    match name {
        RecordName::Unknown { name, .. } if NORMAL.contains(&name.as_str()) => None,
        RecordName::Unknown { name, .. } => Some(name.clone()),
        RecordName::TimeStamp | RecordName::ReturnIndex | RecordName::ReturnCount => {
            Some(format!("{name:?}"))
        }
        _ => None,
    }
}

/// The bits of a value.
pub(super) fn bits(kind: &RecordDataType) -> u128 {
    match kind {
        RecordDataType::Single { .. } => 32,
        RecordDataType::Double { .. } => 64,
        RecordDataType::ScaledInteger { min, max, .. } | RecordDataType::Integer { min, max } => {
            let range = i128::from(*max) - i128::from(*min);
            u128::from(128 - range.max(0).leading_zeros())
        }
    }
}

/// The values of one point.
pub(super) struct Reading<'a> {
    pub(super) fields: &'a Fields,
    /// The values of each field, where they are looked at.
    pub(super) columns: &'a [Vec<f64>],
    /// Which of the values are those of the point.
    pub(super) point: usize,
}

impl Reading<'_> {
    /// The number in a field. It is NaN if there is none, which the reader does not let
    /// happen.
    fn number(&self, field: usize) -> f64 {
        let column = self.columns.get(field);
        column.and_then(|column| column.get(self.point)).copied().unwrap_or(f64::NAN)
    }

    /// Whether a state says nothing against a value. (Some writers store states as floating
    /// point numbers.)
    fn is_valid(&self, state: Option<usize>) -> bool {
        state.is_none_or(|field| self.number(field) == 0.0)
    }

    /// The position in the frame of the scan, unless it is marked as invalid.
    pub(super) fn position(&self) -> Option<[f64; 3]> {
        let fields = self.fields;
        let cartesian = fields.cartesian.filter(|_| self.is_valid(fields.cartesian_state));
        if let Some(xyz) = cartesian {
            return Some(xyz.map(|field| self.number(field)));
        }
        let spherical = fields.spherical.filter(|_| self.is_valid(fields.spherical_state))?;
        let [range, azimuth, elevation] = spherical.map(|field| self.number(field));
        let plane = range * elevation.cos();
        Some([plane * azimuth.cos(), plane * azimuth.sin(), range * elevation.sin()])
    }

    pub(super) fn normal(&self) -> [f64; 3] {
        self.fields.normal.map_or([0.0; 3], |normal| normal.map(|field| self.number(field)))
    }

    pub(super) fn intensity(&self) -> Option<f64> {
        let field = self.fields.intensity.filter(|_| self.is_valid(self.fields.intensity_state))?;
        Some(self.number(field))
    }

    pub(super) fn has_colour(&self) -> bool {
        self.fields.colour.is_some() && self.is_valid(self.fields.colour_state)
    }

    /// The row and the column.
    pub(super) fn cell(&self) -> Option<[f64; 2]> {
        self.fields.row_column.map(|both| both.map(|field| self.number(field)))
    }
}
