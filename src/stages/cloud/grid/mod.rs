//! Triangles along the grid of a scan. A cloud of one scan goes in; triangles over its points come
//! out, with the spacing and the noise, or the reason why its grid is not followed.
//!
//! The grid says which points are neighbours, so noise cannot mislead the triangles. They are cut
//! at jumps of depth ([`jumps`]), as Turk and Levoy ("Zippered polygon meshes from range images",
//! 1994) do, with another rule for what a jump is. The first and the last column of a scan all
//! around are not joined. The points stay where they were measured.

mod belief;
mod cells;
mod facing;
mod jumps;
mod noise;
mod raster;
#[cfg(test)]
mod tests;

use formats::points::PointScan;
use formats::{Points, Soup};

pub use belief::GridDoubt;
pub use facing::Outside;

use super::manifold::ManifoldMesh;
use super::order::WorkFrame;
use super::{LEFT_OUT, Options, Report, Triangulation};
use crate::geometry::{Point, VertexId};
use crate::mesh::Mesh;
use crate::statistics::median;
use facing::ScannerHints;
use jumps::GridEdges;
use raster::Raster;

/// What became of the grid of a cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum GridUse {
    /// No scan has a grid.
    #[default]
    Absent,
    /// The triangles follow the grid.
    Followed {
        /// The number of its edges that were cut because of a jump of depth.
        cut: usize,
        /// What decided which side of the surface is outside.
        outside: Outside,
    },
    /// The grid is not followed, because it is not believed.
    Doubted(GridDoubt),
    /// The grids are not followed, because the cloud has several scans.
    Several,
    /// The grid is not followed, because another spacing was named, or fewer points are to be meshed.
    OtherSpacing,
}

/// Makes triangles along the grid of a cloud.
///
/// # Errors
/// The reason why no grid is followed.
pub(super) fn triangulate_grid(
    cloud: &Points,
    options: &Options,
) -> Result<Triangulation, GridUse> {
    let scan = match cloud.scans.as_slice() {
        [scan] if scan.grid.is_some() => scan,
        scans if scans.iter().all(|scan| scan.grid.is_none()) => return Err(GridUse::Absent),
        _ => return Err(GridUse::Several),
    };
    let is_crowded = options.most_places.is_some_and(|most| cloud.len() > most);
    if options.spacing.is_some() || is_crowded {
        return Err(GridUse::OtherSpacing);
    }
    let frame = WorkFrame::new(&cloud.positions);
    let mut surface = GridSurface::new(cloud, scan, &frame).map_err(GridUse::Doubted)?;
    surface.mesh = ManifoldMesh::with_all_pieces(surface.mesh).mesh;
    Ok(finished(cloud, &frame, &surface))
}

/// The triangles along a grid. Lengths are those of the work.
struct GridSurface {
    /// All points of the cloud, and the triangles, which are counter-clockwise seen from the side
    /// that the scanner saw.
    mesh: Mesh,
    /// The median spacing of the points: the square root of the area for each of them.
    spacing: f64,
    /// The standard deviation of the points along the normal.
    noise: f64,
    /// The number of edges that were cut because of a jump of depth.
    cut: usize,
    /// What decided which side is outside.
    outside: Outside,
}

impl GridSurface {
    fn new(cloud: &Points, scan: &PointScan, frame: &WorkFrame) -> Result<Self, GridDoubt> {
        let grid = scan.grid.as_ref().ok_or(GridDoubt::Sparse)?;
        let points: Vec<Point> = cloud.positions.iter().map(|&p| frame.inward(p)).collect();
        let raster = Raster::new(&points, grid).ok_or(GridDoubt::Inconsistent)?;
        if !belief::has_near_neighbours(&points, &raster) {
            return Err(GridDoubt::MadeUp);
        }
        let edges = GridEdges::new(&raster);
        let triangles = cells::triangles(&raster, &edges);
        let spacing = spacing(&points, &triangles);
        let noise = noise::measure(&raster, &edges, spacing).ok_or(GridDoubt::Sparse)?;
        let mut mesh = Mesh { points, triangles };
        let hints = ScannerHints {
            viewpoint: scan.viewpoint.map(|place| frame.inward(place)),
            normals: cloud.normals.as_deref().filter(|normals| normals.len() == cloud.len()),
            zero: frame.inward(cloud.origin.map(|x| -x)),
        };
        let outside = facing::face_scanner(&mut mesh, &hints);
        Ok(GridSurface { mesh, spacing, noise, cut: edges.cut(), outside })
    }
}

/// The median over the triangles of the root of twice their area: a point has two triangles.
fn spacing(points: &[Point], triangles: &[[VertexId; 3]]) -> f64 {
    let side = |t: &[VertexId; 3]| {
        let [a, b, c] = t.map(|v| points[v.index()]);
        (b - a).cross(&(c - a)).norm().sqrt()
    };
    let mut sides: Vec<f64> = triangles.iter().map(side).collect();
    median(&mut sides).unwrap_or(0.0)
}

/// The result, with only those points that triangles use.
fn finished(cloud: &Points, frame: &WorkFrame, surface: &GridSurface) -> Triangulation {
    let mut soup = Soup { unit: cloud.unit, ..Soup::default() };
    let mut vertex_of = vec![LEFT_OUT; cloud.len()];
    surface.mesh.triangles.iter().flatten().for_each(|v| vertex_of[v.index()] = 0);
    for (position, vertex) in cloud.positions.iter().zip(&mut vertex_of) {
        if *vertex != LEFT_OUT {
            *vertex = soup.points.len() as u32;
            soup.points.push(*position);
        }
    }
    for t in &surface.mesh.triangles {
        soup.polygons.push(t.map(|v| vertex_of[v.index()]));
    }
    let report = Report {
        points: cloud.len(),
        outliers: cloud.len() - soup.points.len(),
        spacing: frame.length(surface.spacing),
        noise: frame.length(surface.noise),
        vertices: soup.points.len(),
        triangles: soup.polygons.len(),
        grid: GridUse::Followed { cut: surface.cut, outside: surface.outside },
        ..Report::default()
    };
    Triangulation { soup, vertex_of, measured: Vec::new(), report }
}
