//! Numbers formatted for people, and what repairs are called.

pub use formats::words::{grouped, plural, printable, printable_lines};

/// Formats a length in mm with four significant digits. Scans range from the size of a mountain to,
/// with a wrong unit, the size of a grain.
pub fn mm(length: f64) -> String {
    significant(length) + " mm"
}

/// A number that is not negative with four significant digits.
pub fn significant(number: f64) -> String {
    let digits = if number > 0.0 { 3 - number.log10().floor() as i32 } else { 0 };
    format!("{number:.*}", digits.clamp(0, 12) as usize)
}

/// A number with the digits before its point in groups, as [`grouped`] has them: "12,346 mm".
pub(crate) fn separated(number: &str) -> String {
    let end = number.find(|c: char| !c.is_ascii_digit()).unwrap_or(number.len());
    let (whole, rest) = number.split_at(end);
    whole.parse::<u64>().map_or(whole.to_owned(), grouped) + rest
}

/// The extents of a box: "100.3 × 80.24 × 17.41 mm".
pub fn extents(size: [f64; 3]) -> String {
    size.map(plain_mm).join(" × ") + " mm"
}

/// The extents of the box with these corners.
pub fn box_extents([low, high]: [[f64; 3]; 2]) -> String {
    extents([0, 1, 2].map(|axis| high[axis] - low[axis]))
}

/// A length in mm without its unit, which stands beside.
pub fn plain_mm(length: f64) -> String {
    separated(&significant(length))
}

/// A number of bytes in units of 1000, with one digit behind the point: "65.5 MB".
pub(crate) fn bytes(count: u64) -> String {
    const UNITS: [&str; 6] = ["kB", "MB", "GB", "TB", "PB", "EB"];
    if count < 1000 {
        return format!("{count} B");
    }
    // A value that rounds to 1000.0 stays in its unit.
    let power = count.ilog10() / 3;
    let unit = UNITS.get(power as usize - 1).copied().unwrap_or("EB");
    format!("{:.1} {unit}", count as f64 / 1000f64.powi(power as i32))
}

/// Why a tolerance that the user did not name has its value.
pub fn tolerance_reason(tolerance: f64, noise: f64) -> String {
    match noise {
        0.0 => "from what flat triangles miss, as the scan shows no noise".into(),
        noise if tolerance > 3.01 * noise => {
            format!(
                "from the scan's size and what flat triangles miss, as its noise is only {}",
                mm(noise)
            )
        }
        noise => format!("three times the noise of {}", mm(noise)),
    }
}

/// The kinds of repairs, and what was done in plain words: the thing, and what happened to it.
const REPAIRS: [(&str, &str, &str); 17] = [
    ("degenerate_faces", "face", " without area left out"),
    ("duplicate_faces", "face", " left out, because the file has it twice"),
    ("dust_components", "tiny piece", " left out"),
    ("faces_dropped_at_bow_ties", "face", " left out where the surface touches itself at a point"),
    ("faces_dropped_at_non_manifold_edges", "face", " left out at edges of more than two faces"),
    ("faces_with_non_finite_vertices", "face", " left out, with a corner that is not a number"),
    ("flipped_faces", "face", " turned to face the same way as the others"),
    (
        "joined_rim_vertices",
        "vertex",
        " of rims joined with another one that is far nearer than the edges there",
    ),
    ("non_finite_vertices", "vertex", " left out, with coordinates that are not numbers"),
    ("opened_edges", "edge", " separated where more than two faces met"),
    ("opened_vertices", "vertex", " added to separate sheets that met at a point"),
    ("polygons_that_cross_themselves", "polygon", " that crosses itself divided into triangles"),
    ("polygons_triangulated", "polygon", " divided into triangles"),
    ("rim_triangles_trimmed", "triangle", " trimmed off ragged rims"),
    ("spikes_dropped", "spike", " left out"),
    ("unused_vertices", "vertex", " left out that no face uses"),
    ("welded_vertices", "vertex", " joined with another one at the same place"),
];

/// What a repair did, in plain words: "3 triangles trimmed off ragged rims".
pub fn repair(kind: &str, count: usize) -> String {
    match REPAIRS.into_iter().find(|(known, ..)| *known == kind) {
        Some((_, thing, done)) => plural(count, thing) + done,
        None => format!("{} {}", grouped(count), kind.replace('_', " ")),
    }
}

#[cfg(test)]
mod tests {
    use super::{REPAIRS, box_extents, bytes, extents, mm, repair, separated};

    #[test]
    fn bytes_have_the_largest_unit_below_them() {
        assert_eq!(bytes(0), "0 B");
        assert_eq!(bytes(999), "999 B");
        assert_eq!(bytes(1000), "1.0 kB");
        assert_eq!(bytes(65_456_999), "65.5 MB");
        assert_eq!(bytes(u64::MAX), "18.4 EB");
    }

    /// A new kind of repair gets words of its own.
    #[test]
    fn every_repair_has_words() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/src/mesh");
        let mut found = 0;
        for file in std::fs::read_dir(folder).unwrap() {
            let path = file.unwrap().path();
            let code =
                if path.is_file() { std::fs::read_to_string(path).unwrap() } else { continue };
            for call in code.split("count(").skip(1) {
                let mut texts = call.split(';').next().unwrap_or("").split('"');
                let is_repair = texts.next().is_some_and(|first| first.contains("repairs"));
                let Some(kind) = texts.next().filter(|_| is_repair) else { continue };
                found += 1;
                assert!(REPAIRS.iter().any(|(known, ..)| *known == kind), "{kind}");
            }
        }
        assert!(found > 10, "{found}");
        assert_eq!(repair("unused_vertices", 1), "1 vertex left out that no face uses");
        assert_eq!(repair("of_another_crate", 2), "2 of another crate");
    }

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(separated("1234567"), "1,234,567");
        assert_eq!(separated("53469.25 mm"), "53,469.25 mm");
        assert_eq!(["999", "0.123456", "-0.5", ""].map(separated), ["999", "0.123456", "-0.5", ""]);
    }

    #[test]
    fn a_box_has_one_unit() {
        let bounds = [[-1.0, 0.0, 5.0], [1.5, 12_345.6, 5.0]];
        assert_eq!(box_extents(bounds), "2.500 × 12,346 × 0 mm");
    }

    #[test]
    fn lengths_have_four_digits() {
        assert_eq!(mm(0.059712), "0.05971 mm");
        assert_eq!(mm(22.532185), "22.53 mm");
        assert_eq!(mm(53468.6), "53469 mm");
        assert_eq!(mm(0.0), "0 mm");
        assert_eq!(mm(1.2345e-5), "0.00001234 mm");
        assert_eq!(extents([100.0, 2.5, 0.0]), "100.0 × 2.500 × 0 mm");
    }
}
