//! The triangles of a mesh primitive.

use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked::Valid;

use super::scene::bad;
use super::transform::Affine;
use super::{Gear, accessor};
use crate::limits::check_room;
use crate::source::EXPORT_AGAIN;
use crate::{Error, Place, Result, Soup};

/// A small file can place one mesh many times. So many points and corners it
/// may have whatever its size; more only in proportion.
const FREE: u64 = 16 << 20;
const PER_BYTE: u64 = 8;

/// Appends the triangles of `primitive`, a part of mesh `mesh`, at `place`.
/// Points and lines are none.
pub(super) fn read(
    gear: &mut Gear<'_>,
    mesh: usize,
    primitive: &Primitive,
    place: &Affine,
    soup: &mut Soup,
) -> Result<()> {
    let Valid(mode) = primitive.mode else {
        return Err(bad(gear, "mesh", mesh, "consists of an unknown kind of primitive"));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let Some(positions) = primitive.attributes.get(&Valid(Semantic::Positions)) else {
        // The specification leaves the meaning of this to extensions.
        return match gear.compression {
            Some(name) => Err(super::compressed(gear.buffers.path, name)),
            None => Ok(()),
        };
    };
    let points = accessor::positions(gear, positions.value())?;
    let corners = match primitive.indices {
        Some(indices) => Corners::Listed(accessor::indices(gear, indices.value())?),
        None => Corners::All(points.len()),
    };
    if let (Some(at), Some(index)) = (primitive.indices, corners.beyond(points.len())) {
        let count = points.len();
        let what = format!("has a triangle with vertex {index}, but only {count} vertices");
        let error = Error::new(gear.buffers.path, what, EXPORT_AGAIN);
        return Err(error.at(Place::Element("accessor", at.value() as u64)));
    }
    check_budget(gear, soup, points.len(), corners.len())?;
    let first = soup.points.len() as u32;
    soup.points.extend(points.into_iter().map(|point| place.apply(point)));
    let flip = place.mirrors();
    for i in 0..corners.triangles(mode) {
        let [a, b, c] = mode_corners(mode, i).map(|at| first + corners.get(at));
        soup.polygons.push(if flip { [a, c, b] } else { [a, b, c] });
    }
    Ok(())
}

/// Which corners the `i`-th triangle has, in the specification's order.
fn mode_corners(mode: Mode, i: usize) -> [usize; 3] {
    match mode {
        Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
        Mode::TriangleFan => [i + 1, i + 2, 0],
        _ => [3 * i, 3 * i + 1, 3 * i + 2],
    }
}

/// The vertex numbers of a primitive: given, or one vertex after the other.
enum Corners {
    Listed(Vec<u32>),
    All(usize),
}

impl Corners {
    fn len(&self) -> usize {
        match self {
            Corners::Listed(list) => list.len(),
            Corners::All(count) => *count,
        }
    }

    fn get(&self, at: usize) -> u32 {
        match self {
            Corners::Listed(list) => list[at],
            Corners::All(_) => at as u32,
        }
    }

    /// The first number that none of `count` vertices has.
    fn beyond(&self, count: usize) -> Option<u32> {
        match self {
            Corners::Listed(list) => list.iter().copied().find(|&i| i as usize >= count),
            Corners::All(_) => None,
        }
    }

    fn triangles(&self, mode: Mode) -> usize {
        match mode {
            Mode::Triangles => self.len() / 3,
            _ => self.len().saturating_sub(2),
        }
    }
}

fn check_budget(gear: &Gear<'_>, soup: &Soup, points: usize, corners: usize) -> Result<()> {
    // A strip has three corners for each number.
    let (points, corners) = (points as u64, 3 * corners as u64);
    check_room(gear.buffers.path, soup, points, corners)?;
    let total = (soup.points.len() + soup.polygons.corner_count()) as u64 + points + corners;
    if total <= FREE.max(PER_BYTE * gear.buffers.bytes) {
        return Ok(());
    }
    let help = "Its nodes repeat their meshes excessively: export the scan alone.";
    Err(Error::new(gear.buffers.path, "expands to far more than it holds", help))
}
