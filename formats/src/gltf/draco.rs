//! Primitives whose data are packed by Draco (`KHR_draco_mesh_compression`).

use draco_core::{DataType, DecodeLimits, DecoderBuffer, FaceIndex, Mesh, MeshDecoder, PointIndex};

use super::extras::DracoData;
use super::scene::bad;
use super::{Gear, accessor};
use crate::limits::check_density;
use crate::{Result, Soup};

/// The most bytes of a decoded attribute value: three numbers of double precision.
const VALUE: u64 = 24;

/// Appends the triangles of a primitive of mesh `index`. Their number is that of the data: accessors may be wrong.
pub(super) fn read(
    gear: &mut Gear<'_>,
    index: usize,
    data: &DracoData,
    normalized: bool,
    soup: &mut Soup,
) -> Result<()> {
    let bytes = accessor::view(gear, data.buffer_view)?;
    let Some(&position) = data.attributes.get("POSITION") else { return Ok(()) };
    let most = super::primitive::room(gear).min(u64::from(u32::MAX));
    let limits = DecodeLimits::permissive().with_max_points(most);
    let limits = limits.with_max_faces(most).with_max_decoded_bytes(VALUE * most);
    let mut mesh = Mesh::new();
    let packed = bytes.len();
    let decoded = {
        let mut buffer = DecoderBuffer::new(&bytes).with_limits(limits);
        MeshDecoder::new().decode(&mut buffer, &mut mesh)
    };
    let unsound = |gear: &Gear<'_>, why: &str| {
        bad(gear, "mesh", index, &format!("has Draco data that {why}"))
    };
    if let Err(e) = decoded {
        return Err(unsound(gear, &format!("cannot be unpacked: {e}")));
    }
    check_density(gear.buffers.path, mesh.num_points() as u64, packed)?;
    check_density(gear.buffers.path, mesh.num_faces() as u64, packed)?;
    let points = positions(&mesh, position, normalized);
    let Some(points) = points else { return Err(unsound(gear, "has no positions")) };
    super::primitive::check_budget(gear, soup, points.len(), mesh.num_faces())?;
    let count = points.len() as u32;
    let first = soup.points.len() as u32;
    for face in (0..mesh.num_faces()).map(|face| mesh.face(FaceIndex(face as u32))) {
        if face.iter().any(|corner| corner.0 >= count) {
            return Err(unsound(gear, "has a face of a point that does not exist"));
        }
        soup.polygons.push(face.map(|corner| first + corner.0));
    }
    soup.points.extend(points);
    Ok(())
}

/// The positions of the points of a mesh.
fn positions(mesh: &Mesh, attribute: u32, normalized: bool) -> Option<Vec<[f64; 3]>> {
    let attribute = mesh.attribute_by_unique_id(attribute)?;
    if attribute.num_components() != 3 {
        return None;
    }
    let kind = attribute.data_type();
    let size = match kind {
        DataType::Int8 | DataType::Uint8 => 1,
        DataType::Int16 | DataType::Uint16 => 2,
        DataType::Float32 => 4,
        _ => return None,
    };
    let scale = match (normalized, kind) {
        (true, DataType::Int8) => f64::from(i8::MAX),
        (true, DataType::Uint8) => f64::from(u8::MAX),
        (true, DataType::Int16) => f64::from(i16::MAX),
        (true, DataType::Uint16) => f64::from(u16::MAX),
        _ => 1.0,
    };
    let number = |bytes: &[u8]| match (kind, bytes) {
        (DataType::Int8, &[a]) => f64::from(i8::from_le_bytes([a])),
        (DataType::Uint8, &[a]) => f64::from(a),
        (DataType::Int16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::Uint16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (_, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN,
    };
    let (data, stride) =
        (attribute.buffer().data(), usize::try_from(attribute.byte_stride()).ok()?);
    let point = |point: usize| {
        let start =
            (attribute.mapped_index(PointIndex(point as u32)).0 as usize).checked_mul(stride)?;
        let bytes = data.get(start..start.checked_add(3 * size)?)?;
        Some([0, 1, 2].map(|k| {
            (number(&bytes[k * size..(k + 1) * size]) / scale).max(if scale > 1.0 {
                -1.0
            } else {
                f64::NEG_INFINITY
            })
        }))
    };
    (0..mesh.num_points()).map(point).collect()
}
