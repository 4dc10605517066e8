//! LAS and LAZ, written by the crate `las`.

use formats::points::{Note, ReadOptions};
use formats::{Error, LengthUnit, Points};
use las::{Builder, Point, Transform, Vlr};

use crate::seeds::surveys::{geo_keys, las_file, las_header, las_point, wkt};
use crate::support::{cloud, places, refusal};

/// A file of twelve points of the ground with records about the coordinate system.
fn file(format: u8, is_packed: bool, records: Vec<Vlr>) -> Vec<u8> {
    let builder = las_header(format, is_packed, records);
    let points: Vec<Point> = (0..12).map(|i| las_point(&builder, i, 2)).collect();
    las_file(builder, points)
}

/// Points of different classes, the last of which is withheld.
fn classes(format: u8) -> Vec<u8> {
    let builder = las_header(format, false, Vec::new());
    let points = [2, 7, 5, 18, 2, 2]
        .into_iter()
        .enumerate()
        .map(|(i, class)| Point { is_withheld: i == 5, ..las_point(&builder, i as u16, class) });
    let points: Vec<Point> = points.collect();
    las_file(builder, points)
}

fn read(options: ReadOptions, content: Vec<u8>) -> Result<Points, Error> {
    options.read_points_from("scan.las".as_ref(), std::io::Cursor::new(content))
}

#[test]
fn all_formats_have_the_same_points() {
    let builder = las_header(0, false, Vec::new());
    let expected: Vec<_> = (0..12).map(|i| las_point(&builder, i, 2)).collect();
    for format in 0..=10 {
        for is_packed in [false, true] {
            let cloud = cloud("scan", file(format, is_packed, Vec::new()));
            for (place, point) in places(&cloud).iter().zip(&expected) {
                let error = [point.x - place[0], point.y - place[1], point.z - place[2]];
                assert!(error.iter().all(|e| e.abs() <= 0.0006), "{format} {is_packed}: {error:?}");
            }
            assert_eq!((cloud.len(), cloud.lost.intensities), (12, 11), "{format} {is_packed}");
            let has_colour = [2, 3, 5, 7, 8, 10].contains(&format);
            assert_eq!(cloud.lost.colours, if has_colour { 12 } else { 0 }, "{format}");
        }
    }
}

#[test]
fn compression_changes_no_bit() {
    for format in 0..=10 {
        let [plain, packed] =
            [false, true].map(|is_packed| cloud("scan", file(format, is_packed, Vec::new())));
        assert_eq!(plain, packed, "{format}");
    }
}

#[test]
fn the_coordinate_system_says_the_unit() {
    let plane = |unit: &str| wkt(&format!("PROJCS[\"a\",GEOGCS[\"b\"],UNIT[\"c\",{unit}]]"));
    for (record, unit) in [
        (geo_keys(&[[1024, 1], [3076, 9001]]), LengthUnit::Metre),
        (geo_keys(&[[1024, 1], [3076, 9002], [4099, 9003]]), LengthUnit::Foot),
        (geo_keys(&[[1024, 1], [3076, 9003]]), LengthUnit::UsSurveyFoot),
        (geo_keys(&[[1024, 3], [2052, 9001]]), LengthUnit::Metre),
        (plane("1"), LengthUnit::Metre),
        (plane("0.3048"), LengthUnit::Foot),
        (plane("0.3048006096012192"), LengthUnit::UsSurveyFoot),
    ] {
        let cloud = cloud("scan", file(6, false, vec![record]));
        assert_eq!((cloud.unit, cloud.notes.len()), (Some(unit), 0));
    }
    for records in [Vec::new(), vec![geo_keys(&[[1024, 1], [3072, 25832]])]] {
        let cloud = cloud("scan", file(6, false, records));
        assert_eq!(
            (cloud.unit, cloud.notes),
            (Some(LengthUnit::Metre), vec![Note::MetresByCustom])
        );
    }
}

#[test]
fn degrees_and_mixed_units_are_refused() {
    let heights = "COMPD_CS[\"a\",PROJCS[\"b\",UNIT[\"m\",1]],VERT_CS[\"c\",UNIT[\"ft\",0.3048]]]";
    for (record, word) in [
        (geo_keys(&[[1024, 2]]), "degrees"),
        (wkt("GEOGCS[\"a\",UNIT[\"degree\",0.0174]]"), "degrees"),
        (geo_keys(&[[1024, 1], [3076, 9001], [4099, 9003]]), "heights in units of 0.3048"),
        (wkt(heights), "heights in units of 0.3048"),
        (wkt("PROJCS[\"a\",UNIT[\"chain\",20.1168]]"), "a unit of 20.1168 m"),
    ] {
        refusal("scan", file(7, true, vec![record]), word);
    }
}

#[test]
fn degrees_are_told_by_their_steps() {
    let place = |plane_scale: f64| {
        let mut builder = Builder::from((1, 2));
        let transform = |scale| Transform { scale, offset: 0.0 };
        builder.transforms.x = transform(plane_scale);
        builder.transforms.y = transform(plane_scale);
        builder.transforms.z = transform(0.001);
        let point = |i: i32| Point { x: 8.0 + f64::from(i) / 64.0, y: 50.0, ..Point::default() };
        las_file(builder, (0..3).map(point))
    };
    refusal("scan", place(1e-7), "degrees");
    assert_eq!(cloud("scan", place(1e-4)).len(), 3);
}

#[test]
fn noise_and_withheld_points_are_left_out() {
    for format in [1, 6] {
        let cloud = cloud("scan", classes(format));
        let lost = &cloud.lost;
        assert_eq!((cloud.len(), lost.noise, lost.marked, lost.filtered), (3, 2, 1, 0));
    }
}

#[test]
fn options_choose_points() {
    let default = ReadOptions::default;
    for (options, count, filtered) in [
        (ReadOptions { classes: vec![2], ..default() }, 2, 1),
        (ReadOptions { classes: vec![7], ..default() }, 1, 3),
        (ReadOptions { min_intensity: Some(20.0), ..default() }, 2, 1),
        (ReadOptions { classes: vec![2], min_intensity: Some(20.0), ..default() }, 1, 2),
    ] {
        let cloud = read(options.clone(), classes(6)).expect("points");
        assert_eq!((cloud.len(), cloud.lost.filtered), (count, filtered), "{options:?}");
    }
    let error = read(ReadOptions { classes: vec![9], ..default() }, classes(6)).expect_err("none");
    assert!(error.what.contains("asked for"), "{error}");
    for content in ["0 0 1\n1 0 1\n", "v 0 0 0\nv 1 0 0\n"] {
        let options = ReadOptions { classes: vec![2], ..default() };
        let error = read(options, content.into()).expect_err("no classes");
        assert!(error.what.contains("classes"), "{error}");
    }
}

#[test]
fn a_cut_file_gives_its_points_unless_it_is_compressed() {
    let whole = file(0, false, Vec::new());
    let cut = cloud("scan.las", &whole[..whole.len() - 30]);
    let count = Note::CountDiffers { announced: 12, found: 10 };
    assert_eq!((cut.len(), cut.notes), (10, vec![Note::MetresByCustom, count]));
    let whole = file(0, true, Vec::new());
    refusal("scan.laz", &whole[..whole.len() - 20], "chunks");
}

#[test]
fn equal_points_beyond_the_bound_are_refused() {
    let mut whole = file(0, true, Vec::new());
    let count = (u32::MAX - 1).to_le_bytes();
    whole[107..111].copy_from_slice(&count);
    refusal("scan.laz", whole, "announces 4,294,967,294 points");
}
