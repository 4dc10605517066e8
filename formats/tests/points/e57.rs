//! E57, written by the crate `e57`.

use std::io::Cursor;

use e57::{E57Writer, Record, RecordDataType, RecordName, RecordValue};
use formats::points::ReadOptions;
use formats::{LengthUnit, Points};

use crate::seeds::surveys::{e57, with_checksums, without_checksums};
use crate::support::{cloud, places, refusal};

/// The same file with `new` instead of `old` in its description. Both have the same length.
fn changed(old: &str, new: &str) -> Vec<u8> {
    assert_eq!(old.len(), new.len());
    let mut content = without_checksums(&e57());
    let at = content.windows(old.len()).position(|w| w == old.as_bytes());
    let at = at.unwrap_or_else(|| panic!("{}", String::from_utf8_lossy(&content)));
    content[at..at + old.len()].copy_from_slice(new.as_bytes());
    with_checksums(&content)
}

fn near(a: [f64; 3], b: [f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

#[test]
fn scans_have_their_places_grids_and_normals() {
    let cloud = cloud("scan", e57());
    assert_eq!(cloud.unit, Some(LengthUnit::Metre));
    assert_eq!((cloud.len(), cloud.scans.len(), cloud.lost.marked), (8, 2, 1));
    assert_eq!((cloud.lost.intensities, cloud.lost.colours), (5, 0));
    // A quarter turn about z, then the translation.
    let places = places(&cloud);
    assert!(near(places[0], [599_999.5, 800_000.5, 401.0]), "{places:?}");
    assert!(near(places[1], [599_999.5, 800_001.5, 401.0]), "{places:?}");
    // Range 2 at azimuth 0.
    assert!(near(places[5], [2.0, 0.0, 0.0]), "{places:?}");
    let normals = cloud.normals.as_ref().expect("normals");
    assert_eq!((normals[0], normals[5]), ([0.0; 3], [0.0, 0.0, 1.0]));
    check_scans(&cloud);
}

fn check_scans(cloud: &Points) {
    let [first, second] = &cloud.scans[..] else { panic!("{:?}", cloud.scans) };
    let grid = first.grid.as_ref().expect("a grid");
    assert_eq!((grid.rows, grid.columns), (2, 3));
    assert_eq!((grid.point(0, 2), grid.point(1, 1), grid.point(1, 2)), (Some(2), None, Some(4)));
    let stood = |viewpoint: Option<[f64; 3]>| {
        [0, 1, 2].map(|axis| cloud.origin[axis] + viewpoint.expect("a place")[axis])
    };
    assert!(near(stood(first.viewpoint), [600_000.0, 800_000.0, 400.0]));
    assert!(near(stood(second.viewpoint), [0.0; 3]));
    assert!(first.pose.is_some() && second.pose.is_none() && second.grid.is_none());
}

/// Enough points for several packets, so that values begin in one and end in the next.
#[test]
fn points_of_many_packets_are_read() {
    const COUNT: usize = 30_000;
    let content = many(COUNT);
    let cloud = cloud("scan", &content);
    assert_eq!((cloud.len(), cloud.lost.intensities), (COUNT, COUNT as u64));
    for i in 0..COUNT {
        assert_eq!(cloud.absolute(i), many_place(i), "point {i}");
    }
}

fn many_place(i: usize) -> [f64; 3] {
    let [x, z] = [i * 37 % 90_001, i * i % 1009].map(|number| number as f64);
    [(x - 45_000.0) * 0.001 + 0.5, x / 7.0, z / 64.0]
}

/// Fields of 17, 64, 32, 2 and 0 bits.
fn many(count: usize) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = E57Writer::new(&mut file, "file").expect("a writer");
    let record = |name, data_type| Record { name, data_type };
    let (min, max, scale, offset) = (-45_000, 45_000, 0.001, 0.5);
    let prototype = vec![
        record(RecordName::CartesianX, RecordDataType::ScaledInteger { min, max, scale, offset }),
        record(RecordName::CartesianY, RecordDataType::Double { min: None, max: None }),
        record(RecordName::CartesianZ, RecordDataType::Single { min: None, max: None }),
        record(RecordName::CartesianInvalidState, RecordDataType::Integer { min: 0, max: 2 }),
        record(RecordName::Intensity, RecordDataType::Integer { min: 7, max: 7 }),
    ];
    let mut scan = writer.add_pointcloud("scan", prototype).expect("a scan");
    for i in 0..count {
        let [_, y, z] = many_place(i);
        let x = (i * 37 % 90_001) as i64 - 45_000;
        let values = vec![
            RecordValue::ScaledInteger(x),
            RecordValue::Double(y),
            RecordValue::Single(z as f32),
            RecordValue::Integer(0),
            RecordValue::Integer(7),
        ];
        scan.add_point(values).expect("a point");
    }
    scan.finalize().expect("a scan");
    writer.finalize().expect("a file");
    drop(writer);
    file.into_inner()
}

/// The first byte of the section of points of the first scan, and of its packets.
const SECTION: usize = 48;
const PACKET: usize = 80;

/// An index and nothing may stand before the points.
#[test]
fn packets_without_points_are_passed_over() {
    let mut content = without_checksums(&e57());
    let length = u64::from_le_bytes(content[SECTION + 8..SECTION + 16].try_into().expect("eight"));
    let points = content[PACKET..SECTION + length as usize].to_vec();
    let start = content.len();
    for kind in [0, 2] {
        content.extend([kind, 0, 23, 0]);
        content.extend([0; 20]);
    }
    content.extend(points);
    let physical = (start / 1020 * 1024 + start % 1020) as u64;
    content[SECTION + 16..SECTION + 24].copy_from_slice(&physical.to_le_bytes());
    let moved = cloud("scan", with_checksums(&content));
    assert_eq!(places(&moved), places(&cloud("scan", e57())));
    content[start] = 3;
    refusal("scan.e57", with_checksums(&content), "a packet is of an unknown type");
    content[start..start + 4].copy_from_slice(&[0, 0, 1, 0]);
    refusal("scan.e57", with_checksums(&content), "an impossible length");
}

#[test]
fn a_packet_of_other_fields_is_refused() {
    for (at, byte) in [(PACKET + 4, 6), (PACKET + 6, 0xff), (PACKET + 7, 0xff)] {
        let mut content = without_checksums(&e57());
        content[at] = byte;
        refusal("scan.e57", with_checksums(&content), "does not hold the fields");
    }
}

#[test]
fn dark_points_can_be_left_out() {
    let content = Cursor::new(e57());
    let options = ReadOptions { min_intensity: Some(2.0), ..ReadOptions::default() };
    let error = options.read_points_from("scan.e57".as_ref(), content);
    assert!(error.expect_err("the second scan has none").what.contains("without intensities"));
}

#[test]
fn what_the_crate_would_believe_is_refused() {
    for (old, new, word) in [
        ("scale=\"0.001\"", "scale=\"NaN  \"", "unreadable"),
        ("scale=\"0.001\"", "scale=\"0.000\"", "a scale or an offset"),
        ("offset=\"0.5\"", "offset=\"inf\"", "a scale or an offset"),
        ("<w type=\"Float\">0.70", "<w type=\"Float\">0.90", "a pose that is none"),
        ("recordCount=\"3\"", "recordCount=\"9\"", "point in scan 1"),
    ] {
        refusal("scan.e57", changed(old, new), word);
    }
}

#[test]
fn a_damaged_page_is_refused() {
    let mut content = e57();
    let at = content.len() / 2;
    content[at] ^= 1;
    refusal("scan.e57", content, "checksum");
    let whole = e57();
    refusal("scan.e57", &whole[..whole.len() - 64], "truncated");
}
