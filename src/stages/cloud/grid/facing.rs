//! The side of a surface that the scanner saw. A mesh and what the file says about the scanner go
//! in; a mesh whose triangles are counter-clockwise seen from there comes out.
//!
//! The triangles of a grid agree with each other already, so one decision turns all of them. Each
//! triangle votes, because noise turns single ones over.

use crate::geometry::{Point, Vector, VertexId, bounds};
use crate::mesh::Mesh;

/// What decided which side of a surface is outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outside {
    /// The place of the scanner.
    Viewpoint,
    /// The normals of the file.
    Normals,
    /// The zero of the file's coordinates, which was taken for the place of the scanner.
    Zero,
    /// The order of rows and columns. Seen by the scanner, columns run to the right and rows
    /// upwards, as in Stanford's range scans. This is a guess.
    RowOrder,
}

/// The zero of the coordinates is taken for the scanner's place only if it sees at least this share
/// of the triangles from the same side, and if it is outside of the bounds of the points. A scanner that stands there sees all but some that noise
/// has turned over; a zero at any other place sees about half.
const SEEN_FROM_ZERO: f64 = 0.95;

/// What the file says about the place of the scanner.
pub(super) struct ScannerHints<'a> {
    /// The place of the scanner, in the coordinates of the points.
    pub(super) viewpoint: Option<Point>,
    /// The normals of the points.
    pub(super) normals: Option<&'a [[f32; 3]]>,
    /// The zero of the file, in the coordinates of the points.
    pub(super) zero: Point,
}

/// Turns the triangles of a mesh, which are made for rows that run downwards, to the side that the
/// scanner saw.
pub(super) fn face_scanner(mesh: &mut Mesh, hints: &ScannerHints) -> Outside {
    let (votes, outside) = decide(mesh, hints);
    if votes < 0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    outside
}

/// How many more triangles are turned to the scanner than away, and how this is known.
fn decide(mesh: &Mesh, hints: &ScannerHints) -> (i64, Outside) {
    let from_place = |place: Point| votes(mesh, |t| place - mesh.points[t[0].index()]);
    if let Some(viewpoint) = hints.viewpoint {
        return (from_place(viewpoint), Outside::Viewpoint);
    }
    if let Some(normals) = hints.normals {
        let normal = |v: VertexId| Vector::from(normals[v.index()].map(f64::from));
        let count = votes(mesh, |t| t.into_iter().map(normal).sum());
        if count != 0 {
            return (count, Outside::Normals);
        }
    }
    let zero = hints.zero;
    let [low, high] = bounds(mesh.points.iter().copied());
    let is_outside = (0..3).any(|i| zero[i] < low[i] || zero[i] > high[i]);
    let count = from_place(zero);
    let share = count.unsigned_abs() as f64 / mesh.triangles.len().max(1) as f64;
    // The votes of both sides differ by twice what the larger side has more than half.
    match is_outside && share >= 2.0 * SEEN_FROM_ZERO - 1.0 {
        true => (count, Outside::Zero),
        false => (-1, Outside::RowOrder),
    }
}

/// The number of triangles whose normal agrees with a direction, less those whose does not.
fn votes(mesh: &Mesh, direction: impl Fn([VertexId; 3]) -> Vector) -> i64 {
    let vote = |&t: &[VertexId; 3]| {
        let height = mesh.area_vector(t).dot(&direction(t));
        i64::from(height > 0.0) - i64::from(height < 0.0)
    };
    mesh.triangles.iter().map(vote).sum()
}
