//! The triangles of a mesh primitive.

use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked::Valid;

use super::scene::bad;
use super::{Gear, accessor, draco};
use crate::limits::check_room;
use crate::scene::{self, soup_bytes};
use crate::source::EXPORT_AGAIN;
use crate::words::plural;
use crate::{Error, Location, Result, Soup};

/// Appends the triangles of the primitive with number `place.1` of mesh `place.0`. Primitives of points and lines are
/// skipped.
pub(super) fn read(
    gear: &mut Gear<'_>,
    place: (usize, usize),
    primitive: &Primitive,
    soup: &mut Soup,
) -> Result<()> {
    if let Some(data) =
        gear.extras.draco.get(&place).cloned().filter(|_| is_of_triangles(primitive))
    {
        let positions = primitive.attributes.get(&Valid(Semantic::Positions));
        let accessors = &gear.document.as_json().accessors;
        let accessor = positions.and_then(|positions| accessors.get(positions.value()));
        let normalized = accessor.is_some_and(|accessor| accessor.normalized);
        return draco::read(gear, place.0, &data, normalized, soup);
    }
    let Some(IndexedTriangles { mode, corners, points }) = load(gear, place.0, primitive)? else {
        return Ok(());
    };
    check_budget(gear, soup, points.len(), corners.triangles(mode))?;
    let first = soup.points.len() as u32;
    soup.points.extend(points);
    for i in 0..corners.triangles(mode) {
        soup.polygons.push(mode_corners(mode, i).map(|at| first + corners.get(at)));
    }
    Ok(())
}

/// Checks `primitive` as `read` does, and returns the number of bytes that it would take.
pub(super) fn size(gear: &mut Gear<'_>, mesh: usize, primitive: &Primitive) -> Result<u64> {
    if let Some(IndexedTriangles { mode, corners, points }) = load(gear, mesh, primitive)? {
        return Ok(soup_bytes(points.len() as u64, corners.triangles(mode) as u64));
    }
    // The indices must exist for every type of primitive.
    let indices = primitive.indices.map(|at| accessor::indices(gear, at.value()));
    Ok(indices.transpose()?.map_or(0, |list| 4 * list.len() as u64))
}

/// Whether `primitive` consists of triangles.
pub(super) fn is_of_triangles(primitive: &Primitive) -> bool {
    matches!(primitive.mode, Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan))
}

/// The data of a primitive of triangles.
struct IndexedTriangles {
    mode: Mode,
    corners: CornerIndices,
    points: Vec<[f64; 3]>,
}

fn load(
    gear: &mut Gear<'_>,
    mesh: usize,
    primitive: &Primitive,
) -> Result<Option<IndexedTriangles>> {
    let Valid(mode) = primitive.mode else {
        return Err(bad(gear, "mesh", mesh, "consists of an unknown kind of primitive"));
    };
    if !is_of_triangles(primitive) {
        return Ok(None);
    }
    let Some(positions) = primitive.attributes.get(&Valid(Semantic::Positions)) else {
        // The specification allows this only for extensions.
        return Ok(None);
    };
    let positions = positions.value();
    let listed = match primitive.indices {
        Some(indices) => Some(listed(gear, indices.value(), positions)?),
        None => None,
    };
    let points = accessor::positions(gear, positions)?;
    let corners = listed.map_or(CornerIndices::All(points.len()), CornerIndices::Listed);
    Ok(Some(IndexedTriangles { mode, corners, points }))
}

/// The vertex indices in accessor `indices`. They are checked against the number of `positions`.
fn listed(gear: &mut Gear<'_>, indices: usize, positions: usize) -> Result<Vec<u32>> {
    let list = accessor::indices(gear, indices)?;
    let Some(count) = accessor::count(gear, positions) else { return Ok(list) };
    if let Some(index) = list.iter().find(|&&i| u64::from(i) >= count) {
        let what =
            format!("has a triangle with vertex {index}, but only {}", plural(count, "vertex"));
        let error = Error::new(gear.buffers.path, what, EXPORT_AGAIN);
        return Err(error.at(Location::Element("accessor", indices as u64)));
    }
    Ok(list)
}

/// The corners of the `i`-th triangle in the order of the specification.
fn mode_corners(mode: Mode, i: usize) -> [usize; 3] {
    match mode {
        Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
        Mode::TriangleFan => [i + 1, i + 2, 0],
        _ => [3 * i, 3 * i + 1, 3 * i + 2],
    }
}

/// The vertex indices of a primitive: a list, or all vertices in order.
enum CornerIndices {
    Listed(Vec<u32>),
    All(usize),
}

impl CornerIndices {
    fn len(&self) -> usize {
        match self {
            CornerIndices::Listed(list) => list.len(),
            CornerIndices::All(count) => *count,
        }
    }

    fn get(&self, at: usize) -> u32 {
        match self {
            CornerIndices::Listed(list) => list[at],
            CornerIndices::All(_) => at as u32,
        }
    }

    fn triangles(&self, mode: Mode) -> usize {
        match mode {
            Mode::Triangles => self.len() / 3,
            _ => self.len().saturating_sub(2),
        }
    }
}

/// The number of bytes that the soups of all meshes may have.
pub(super) fn budget(gear: &Gear<'_>) -> u64 {
    scene::budget(gear.buffers.bytes)
}

/// The number of bytes that they may still have.
pub(super) fn room(gear: &Gear<'_>) -> u64 {
    budget(gear).saturating_sub(gear.taken)
}

/// Checks that a soup may have so many more points and triangles, and takes their room.
pub(super) fn check_budget(
    gear: &mut Gear<'_>,
    soup: &Soup,
    points: usize,
    triangles: usize,
) -> Result<()> {
    let (points, triangles) = (points as u64, triangles as u64);
    check_room(gear.buffers.path, soup, points, 3 * triangles)?;
    gear.taken = gear.taken.saturating_add(soup_bytes(points, triangles));
    if gear.taken <= budget(gear) {
        return Ok(());
    }
    let help = "Its meshes repeat their data excessively: export the scan alone.";
    Err(Error::new(gear.buffers.path, "expands to far more than it holds", help))
}
