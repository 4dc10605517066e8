//! The unit of the coordinate system of a LAS file.
//!
//! The input is the records about the coordinate system: keys of GeoTIFF (OGC 19-008) or
//! well-known text (OGC 01-009, ISO 19162). The output is a [`CrsUnit`]. A code of EPSG
//! alone says nothing here, because this crate has no list of the codes.

use las::crs::{GeoTiffCrs, GeoTiffData};
use las::{Builder, Header, Vlr};

use super::wkt::{self, WktNode};
use crate::LengthUnit;

/// What the coordinates are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum CrsUnit {
    /// Nothing says it.
    Unknown,
    /// Longitude and latitude.
    Degrees,
    /// Lengths in a unit.
    Length(LengthUnit),
    /// Lengths in another unit, of so many metres.
    Other(f64),
    /// Lengths whose heights are in another unit: those of the plane and the heights, in
    /// metres.
    Mixed([f64; 2]),
}

/// Units whose lengths differ by less than this part are the same. The numbers in files are
/// rounded to ten digits. International and US feet differ by 2e-6.
const SAME: f64 = 1e-7;

/// Heights may differ by this part: nobody distinguishes the two feet in heights, where
/// they differ by less than a millimetre in 400 m.
const SAME_HEIGHTS: f64 = 1e-5;

/// The unit that the records in `records` declare.
pub(super) fn unit(records: Vec<Vlr>, prefers_text: bool) -> CrsUnit {
    let mut builder = Builder::from((1, 4));
    builder.vlrs = records;
    let Ok(header) = builder.into_header() else { return CrsUnit::Unknown };
    let units = [of_text(&header), of_keys(&header)];
    let mut order = if prefers_text { [units[0], units[1]] } else { [units[1], units[0]] };
    order.sort_by_key(|&unit| unit == CrsUnit::Unknown);
    order[0]
}

/// The keys of GeoTIFF that matter.
const MODEL_TYPE: u16 = 1024;
const GEODETIC_UNIT: u16 = 2052;
const PROJECTED_UNIT: u16 = 3076;
const VERTICAL_UNIT: u16 = 4099;

fn of_keys(header: &Header) -> CrsUnit {
    let Ok(Some(keys)) = header.get_geotiff_crs() else { return CrsUnit::Unknown };
    let unit = match key(&keys, MODEL_TYPE) {
        Some(2) => return CrsUnit::Degrees,
        Some(3) => GEODETIC_UNIT,
        _ => PROJECTED_UNIT,
    };
    let metres = |code| match code {
        9001 => Some(1.0),
        9002 => Some(LengthUnit::Foot.in_mm() / LengthUnit::Metre.in_mm()),
        9003 => Some(LengthUnit::UsSurveyFoot.in_mm() / LengthUnit::Metre.in_mm()),
        _ => None,
    };
    let plane = key(&keys, unit).and_then(metres);
    of_lengths(plane, key(&keys, VERTICAL_UNIT).and_then(metres))
}

fn key(keys: &GeoTiffCrs, id: u16) -> Option<u16> {
    keys.entries.iter().find(|entry| entry.id == id).and_then(|entry| match entry.data {
        GeoTiffData::U16(value) => Some(value),
        GeoTiffData::String(_) | GeoTiffData::Doubles(_) => None,
    })
}

fn of_text(header: &Header) -> CrsUnit {
    let text = header.get_wkt_crs_bytes().unwrap_or_default();
    let Some(root) = std::str::from_utf8(text).ok().and_then(wkt::parse) else {
        return CrsUnit::Unknown;
    };
    let compound = ["COMPD_CS", "COMPOUNDCRS"];
    let parts = if root.is(&compound) { root.children.iter().collect() } else { vec![&root] };
    let part = |names: &[&str]| parts.iter().copied().find(|part| part.is(names));
    if part(&["GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"]).is_some() {
        return CrsUnit::Degrees;
    }
    let projected = ["PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS"];
    let geocentric = ["GEOCCS", "GEODCRS", "GEODETICCRS"];
    let plane = part(&projected).or_else(|| part(&geocentric)).and_then(metres);
    of_lengths(plane, part(&["VERT_CS", "VERTCRS", "VERTICALCRS"]).and_then(metres))
}

/// The unit of a system: its own, or that of its first axis.
fn metres(system: &WktNode) -> Option<f64> {
    let names = ["UNIT", "LENGTHUNIT"];
    let own = system.child(&names);
    let unit = own.or_else(|| system.child(&["AXIS"]).and_then(|axis| axis.child(&names)))?;
    unit.numbers.first().copied().filter(|metres| metres.is_normal() && *metres > 0.0)
}

fn of_lengths(plane: Option<f64>, heights: Option<f64>) -> CrsUnit {
    let same = |a: f64, b: f64, part: f64| (a - b).abs() <= part * b;
    match (plane, heights) {
        (None, _) => CrsUnit::Unknown,
        (Some(plane), Some(heights)) if !same(heights, plane, SAME_HEIGHTS) => {
            CrsUnit::Mixed([plane, heights])
        }
        (Some(plane), _) => {
            let known = [LengthUnit::Metre, LengthUnit::Foot, LengthUnit::UsSurveyFoot];
            let unit = known
                .into_iter()
                .find(|unit| same(plane, unit.in_mm() / LengthUnit::Metre.in_mm(), SAME));
            unit.map_or(CrsUnit::Other(plane), CrsUnit::Length)
        }
    }
}
