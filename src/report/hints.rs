//! What could be better, and what the user can do about it: the hints of each face, and those
//! that concern the scan as a whole.

use formats::LengthUnit;

use super::{ScanSource, Setting, Settings, unused};
use crate::convert::{Body, Conversion};
use crate::geometry::{Vector, box_of};
use crate::words::{mm, plural};

/// The hints of a conversion.
pub(super) fn of(conversion: &Conversion, source: &ScanSource, settings: &Settings) -> Vec<String> {
    let bodies: Vec<&Body> = conversion.bodies().collect();
    let mut hints: Vec<String> =
        odd_size(source, bodies.iter().map(|body| &body.input.bounds)).into_iter().collect();
    let shape = bodies.first().map(|body| body.shape.word());
    hints.extend(shape.into_iter().flat_map(|shape| unused::of(settings, source, shape)));
    for body in &bodies {
        let part = match bodies.len() {
            1 => String::new(),
            _ => format!("component {}: ", body.input.component),
        };
        let other = settings.faces.and_then(|wanted| other_faces(body, wanted));
        let own = body
            .hints
            .iter()
            .cloned()
            .chain(left_out(settings, body))
            .chain(beside(settings, source, body));
        let own = own.chain(other);
        hints.extend(own.map(|hint| part.clone() + &hint));
    }
    hints
}

/// A number of faces is about the wanted one up to this share of it. Layouts are searched by halving an angle, which
/// comes as near on most bodies.
const ABOUT: f64 = 0.2;

/// A hint about a body that has not about as many faces as are wanted.
fn other_faces(body: &Body, wanted: usize) -> Option<String> {
    let faces = body.network()?.network.surfaces.len();
    let (shape, of) = (body.shape.word(), plural(faces, "face"));
    if (faces.abs_diff(wanted) as f64) <= ABOUT * wanted as f64 {
        return None;
    }
    Some(match faces > wanted {
        true => format!(
            "the {shape} has {of}, and not about {wanted}: on fewer, quads would turn away from the scan"
        ),
        false => format!(
            "the {shape} has {of}, and not about {wanted}: its triangles are too large for more"
        ),
    })
}

/// Sizes of a scan in mm that make the assumed unit likely: more than a thimble, less than a
/// house.
const LIKELY_SIZES: [f64; 2] = [5.0, 50_000.0];

/// Sizes of a scan in mm that make another unit likely: more than a coin, less than a car. Most scans
/// have such a size. With a wider range, several units are likely for most sizes.
const USUAL_SIZES: [f64; 2] = [20.0, 6000.0];

/// The size in mm of what is scanned most: something between a hand and a head.
const MEDIAN_SIZE: f64 = 250.0;

/// The units in which scanners and CAD programs write.
const UNITS: [LengthUnit; 5] = [
    LengthUnit::Millimetre,
    LengthUnit::Metre,
    LengthUnit::Centimetre,
    LengthUnit::Inch,
    LengthUnit::Micrometre,
];

/// A hint about the unit of a scan, if its components with these bounds in mm have an odd size.
fn odd_size<'a>(
    source: &ScanSource,
    components: impl Iterator<Item = &'a [[f64; 3]; 2]>,
) -> Option<String> {
    let corners = components.flatten().map(|&p| p.into());
    likely_unit(source, box_of(corners))
}

fn size([low, high]: [[f64; 3]; 2]) -> f64 {
    (Vector::from(high) - Vector::from(low)).norm()
}

/// The units that the size of a scan suggests, likeliest first. There are none if its unit is known,
/// or if the assumed one is likely. The bounds of the scan are mm.
pub(super) fn likely_units(source: &ScanSource, bounds: [[f64; 3]; 2]) -> Vec<LengthUnit> {
    let Some(across) = unlikely_size(source, bounds) else { return Vec::new() };
    let in_unit = |unit: &LengthUnit| across / source.unit.in_mm() * unit.in_mm();
    let is_usual = |unit: &LengthUnit| (USUAL_SIZES[0]..USUAL_SIZES[1]).contains(&in_unit(unit));
    let mut likely: Vec<_> = UNITS.into_iter().filter(is_usual).collect();
    let distance = |unit: &LengthUnit| (in_unit(unit) / MEDIAN_SIZE).ln().abs();
    likely.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
    likely
}

/// The size of a scan in mm, if its unit was assumed and makes its size unlikely.
fn unlikely_size(source: &ScanSource, bounds: [[f64; 3]; 2]) -> Option<f64> {
    let across = size(bounds);
    let is_likely = (LIKELY_SIZES[0]..LIKELY_SIZES[1]).contains(&across);
    (source.unit_assumed && !is_likely).then_some(across)
}

/// Advice to name the unit of a scan, if its unit was assumed and makes its size unlikely. The
/// bounds of the scan are mm.
pub fn likely_unit(source: &ScanSource, bounds: [[f64; 3]; 2]) -> Option<String> {
    let across = unlikely_size(source, bounds)?;
    let likely = likely_units(source, bounds).into_iter().map(|unit| {
        let across = across / source.unit.in_mm() * unit.in_mm();
        // "in" would read as a preposition.
        let name = if unit == LengthUnit::Inch { "inches" } else { unit.symbol() };
        format!("{name} ({})", mm(across))
    });
    let likely = likely.collect::<Vec<_>>().join(" or ");
    let more_likely =
        if likely.is_empty() { likely } else { format!("more likely they are {likely}; ") };
    let (across, assumed) = (mm(across), source.unit.symbol());
    Some(format!(
        "the scan is {across} across if its numbers are {assumed}; {more_likely}name the unit with --units"
    ))
}

/// The largest deviation of a ratio of sizes from the ratio of two units that it suggests, as a share.
/// Ratios of different units differ by a factor of more than two.
const UNIT_RATIO: f64 = 0.2;

/// Advice to name the unit of a scan whose unit was assumed, if a CAD file of it is larger or smaller by the
/// ratio of two units. The bounds of both are mm.
pub(super) fn unit_by_cad(
    (unit, is_assumed): (LengthUnit, bool),
    scan: [[f64; 3]; 2],
    cad: [[f64; 3]; 2],
) -> Option<String> {
    let [scan, cad] = [size(scan), size(cad)];
    let suits =
        |other: &LengthUnit| (cad / scan * unit.in_mm() / other.in_mm() - 1.0).abs() < UNIT_RATIO;
    let other = UNITS.into_iter().filter(|other| *other != unit).find(suits);
    let other = other.filter(|_| is_assumed)?.symbol();
    Some(format!(
        "the faces are {} across and the scan {}; --units {other} makes them the same size",
        mm(cad),
        mm(scan)
    ))
}

/// The share of the scan's triangles in other components that is worth a hint: a tenth of a
/// scan is more than dust.
const LEFT_OUT: f64 = 0.1;

fn left_out(settings: &Settings, c: &Body) -> Option<String> {
    let all = (c.input.triangles + c.input.island_triangles + c.input.left_out) as f64;
    let share = c.input.left_out as f64 / all.max(1.0);
    (settings.component != Setting::Word("all") && share > LEFT_OUT).then(|| {
        format!(
            "{:.0} % of the scan's triangles are in other pieces; --component all converts every one",
            100.0 * share
        )
    })
}

/// A hint about pieces that touch or overlap the one that was taken. The mesh of a cloud was made of the points of all,
/// so that no option joins its layers.
fn beside(settings: &Settings, source: &ScanSource, c: &Body) -> Option<String> {
    let numbers: Vec<String> = c.input.beside.iter().map(usize::to_string).collect();
    (!numbers.is_empty()).then(|| {
        let (which, does) = match numbers.len() {
            1 => ("component", "touches or overlaps this one and is"),
            _ => ("components", "touch or overlap this one and are"),
        };
        let advice = match (&source.cloud, settings.component == Setting::Word("all")) {
            (None, _) => {
                ": --remesh makes one surface of the points of all; --weld LEN joins only rims whose points lie in pairs"
            }
            (Some(_), true) => ", as layers of points are not",
            (Some(_), false) => ", as layers of points are not; --component all converts each of them",
        };
        format!("{which} {} {does} not joined{advice}", numbers.join(", "))
    })
}
