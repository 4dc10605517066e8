//! The side of a surface that the scanner saw. Triangles and what the file says about the scanner
//! go in; triangles that are counter-clockwise seen from there come out.
//!
//! The triangles of a grid agree with each other already, so one decision turns all of them. Each
//! triangle votes, because noise turns single ones over.

use formats::Points;
use formats::points::PointScan;

use crate::geometry::{Point, Vector, VertexId, bounds};

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

/// Turns the triangles of a scan to the side that the scanner saw.
pub(super) fn face_scanner(
    cloud: &Points,
    scan: &PointScan,
    triangles: &mut [[VertexId; 3]],
) -> Outside {
    let (votes, outside) = decide(cloud, scan, triangles);
    if votes < 0 {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    outside
}

/// How many more triangles are turned to the scanner than away, and how this is known.
fn decide(cloud: &Points, scan: &PointScan, triangles: &[[VertexId; 3]]) -> (i64, Outside) {
    let from_place = |place: Point| votes(cloud, triangles, |at, _| place - at);
    if let Some(viewpoint) = scan.viewpoint {
        return (from_place(Point::from(viewpoint)), Outside::Viewpoint);
    }
    if let Some(normals) = &cloud.normals {
        let normal = |v: VertexId| Vector::from(normals[v.index()].map(f64::from));
        let count = votes(cloud, triangles, |_, t| t.iter().map(|&v| normal(v)).sum());
        if count != 0 {
            return (count, Outside::Normals);
        }
    }
    let zero = Point::from(cloud.origin.map(|x| -x));
    let [low, high] = bounds(cloud.positions[scan.points.clone()].iter().map(|&p| Point::from(p)));
    let is_outside = (0..3).any(|i| zero[i] < low[i] || zero[i] > high[i]);
    let count = from_place(zero);
    let share = count.unsigned_abs() as f64 / triangles.len().max(1) as f64;
    // The votes of both sides differ by twice what the smaller one lacks of the half.
    match is_outside && share >= 2.0 * SEEN_FROM_ZERO - 1.0 {
        true => (count, Outside::Zero),
        // The triangles are made for rows that run downwards.
        false => (-1, Outside::RowOrder),
    }
}

/// The number of triangles whose normal agrees with a direction, less those whose does not. The
/// direction follows from the first corner and the triangle.
fn votes(
    cloud: &Points,
    triangles: &[[VertexId; 3]],
    direction: impl Fn(Point, [VertexId; 3]) -> Vector,
) -> i64 {
    let point = |v: VertexId| Point::from(cloud.positions[v.index()]);
    let vote = |&t: &[VertexId; 3]| {
        let [a, b, c] = t.map(point);
        let height = (b - a).cross(&(c - a)).dot(&direction(a, t));
        i64::from(height > 0.0) - i64::from(height < 0.0)
    };
    triangles.iter().map(vote).sum()
}
