//! Small sound files of E57, LAS and LAZ, written by the crates `e57` and `las`.

use std::io::Cursor;

use e57::{E57Writer, Extension, Quaternion, Record, RecordDataType, RecordName, RecordValue};
use e57::{Transform as E57Pose, Translation};
use las::point::{Classification, Format};
use las::{Builder, Color, Point, Transform, Vector, Vlr, Writer};

/// The bytes of a page of E57 without and with its checksum.
const CONTENT: usize = 1020;
const PAGE: usize = 1024;

/// An E57 file without its checksums.
pub fn without_checksums(file: &[u8]) -> Vec<u8> {
    file.chunks(PAGE).flat_map(|page| &page[..page.len().min(CONTENT)]).copied().collect()
}

/// The same with new checksums.
pub fn with_checksums(content: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    for page in content.chunks(CONTENT) {
        let start = file.len();
        file.extend(page);
        file.resize(start + CONTENT, 0);
        let sum = crc32c::crc32c(&file[start..]).to_be_bytes();
        file.extend(sum);
    }
    file
}

fn integer(max: i64) -> RecordDataType {
    RecordDataType::Integer { min: 0, max }
}

/// Two scans: one on a grid with a pose, and one of ranges and angles with normals.
pub fn e57() -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = E57Writer::new(&mut file, "file").expect("a writer");
    writer.register_extension(Extension::new("nor", "http://www.libe57.org")).expect("new");
    let scaled = |name| {
        let (min, max, scale, offset) = (-100_000, 100_000, 0.001, 0.5);
        Record { name, data_type: RecordDataType::ScaledInteger { min, max, scale, offset } }
    };
    let record = |name, data_type| Record { name, data_type };
    let prototype = vec![
        scaled(RecordName::CartesianX),
        scaled(RecordName::CartesianY),
        scaled(RecordName::CartesianZ),
        record(RecordName::CartesianInvalidState, integer(2)),
        record(RecordName::RowIndex, integer(7)),
        record(RecordName::ColumnIndex, integer(7)),
        record(RecordName::Intensity, RecordDataType::Single { min: Some(0.0), max: Some(9.0) }),
    ];
    let mut scan = writer.add_pointcloud("first", prototype).expect("a scan");
    let rotation = Quaternion { w: 0.5f64.sqrt(), x: 0.0, y: 0.0, z: 0.5f64.sqrt() };
    let translation = Translation { x: 600_000.0, y: 800_000.0, z: 400.0 };
    scan.set_transform(Some(E57Pose { rotation, translation }));
    for i in 0..6 {
        let [x, y, z] = [i % 3 * 1000, i / 3 * 1000, 500].map(RecordValue::ScaledInteger);
        let [state, row, column] =
            [i64::from(i == 4) * 2, 1 + i / 3, i % 3].map(RecordValue::Integer);
        let intensity = RecordValue::Single(i as f32);
        scan.add_point(vec![x, y, z, state, row, column, intensity]).expect("a point");
    }
    scan.finalize().expect("a scan");
    let double = |name| record(name, RecordDataType::Double { min: None, max: None });
    let normal = |name: &str| {
        let name = RecordName::Unknown { namespace: "nor".into(), name: name.into() };
        record(name, RecordDataType::Single { min: None, max: None })
    };
    let prototype = vec![
        double(RecordName::SphericalRange),
        double(RecordName::SphericalAzimuth),
        double(RecordName::SphericalElevation),
        normal("normalX"),
        normal("normalY"),
        normal("normalZ"),
    ];
    let mut scan = writer.add_pointcloud("second", prototype).expect("a scan");
    for i in 0..3 {
        let mut values = [2.0, f64::from(i), 0.0].map(RecordValue::Double).to_vec();
        values.extend([0.0, 0.0, 1.0].map(RecordValue::Single));
        scan.add_point(values).expect("a point");
    }
    scan.finalize().expect("a scan");
    writer.finalize().expect("a file");
    drop(writer);
    file.into_inner()
}

/// The keys of GeoTIFF that say that coordinates are in a unit.
pub fn geo_keys(keys: &[[u16; 2]]) -> Vlr {
    let mut numbers = vec![1, 1, 0, keys.len() as u16];
    numbers.extend(keys.iter().flat_map(|&[id, value]| [id, 0, 1, value]));
    record(34735, numbers.into_iter().flat_map(u16::to_le_bytes).collect())
}

/// A coordinate system as well-known text.
pub fn wkt(text: &str) -> Vlr {
    record(2112, [text.as_bytes(), b"\0"].concat())
}

fn record(record_id: u16, data: Vec<u8>) -> Vlr {
    Vlr { user_id: "LASF_Projection".into(), record_id, data, ..Vlr::default() }
}

/// A header of points far from zero.
pub fn las_header(format: u8, is_packed: bool, records: Vec<Vlr>) -> Builder {
    let mut builder = Builder::from((1, 4));
    builder.point_format = Format::new(format).expect("a format");
    builder.point_format.is_compressed = is_packed;
    let transform = |offset| Transform { scale: 0.001, offset };
    builder.transforms =
        Vector { x: transform(400_000.0), y: transform(5_800_000.0), z: transform(0.0) };
    builder.vlrs = records;
    builder
}

/// A point of a class. Its other values depend on its number.
pub fn las_point(builder: &Builder, i: u16, class: u8) -> Point {
    let [x, y] = [i % 4, i / 4].map(f64::from);
    let format = builder.point_format;
    Point {
        x: 400_000.0 + x,
        y: 5_800_000.0 + y,
        z: 100.0 + f64::from(i * i % 7) / 8.0,
        intensity: 10 * i,
        return_number: 1,
        number_of_returns: 1,
        classification: Classification::new(class).expect("a class"),
        gps_time: format.has_gps_time.then_some(f64::from(i)),
        color: format.has_color.then(|| Color::new(i, 2 * i, 3)),
        nir: format.has_nir.then_some(i),
        waveform: format.has_waveform.then(Default::default),
        extra_bytes: vec![i as u8; usize::from(format.extra_bytes)],
        ..Point::default()
    }
}

pub fn las_file(builder: Builder, points: impl IntoIterator<Item = Point>) -> Vec<u8> {
    let header = builder.into_header().expect("a header");
    let mut writer = Writer::new(Cursor::new(Vec::new()), header).expect("a writer");
    for point in points {
        writer.write_point(point).expect("a point");
    }
    writer.close().expect("a file");
    writer.into_inner().expect("bytes").into_inner()
}

/// Twelve points of the ground with extra bytes.
pub fn las(format: u8, is_packed: bool) -> Vec<u8> {
    let mut builder = las_header(format, is_packed, vec![geo_keys(&[[1024, 1], [3076, 9001]])]);
    builder.point_format.extra_bytes = 2;
    let points: Vec<Point> = (0..12).map(|i| las_point(&builder, i, 2)).collect();
    las_file(builder, points)
}
