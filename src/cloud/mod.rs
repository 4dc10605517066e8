//! Clouds of points. Points without triangles go in. A soup of triangles comes out that is
//! manifold and oriented, and open where there are no points.
//!
//! Points are projected onto the surface that their neighbours sample, by moving least squares
//! (Levin 2003; Alexa et al. 2003). Points that are then close to each other become one vertex. The
//! Voronoi cell of each vertex in its tangent plane proposes triangles (Gopi, Krishnan, Silva 2000;
//! Boltcheva, Lévy 2017), and those are taken on which neighbours agree. The surface goes through
//! the middle of layers, and nothing has to be known about normals or radii.

mod close;
mod grid;
mod manifold;
mod nearest_lists;
mod noise;
mod order;
mod outliers;
mod project;
mod quadric;
mod sides;
mod thin;
mod voronoi;
mod votes;

use formats::{Points, Soup};

pub use grid::{GridDoubt, GridUse, Outside};

use crate::error::{CloudFault, Error, Result, of};
use crate::mesh::{Mesh, Neighbours};
use crate::progress::Progress;
use crate::rules;
use manifold::ManifoldMesh;
use nearest_lists::NearestLists;
use order::Ordered;

/// The vertex of a point that has none.
pub const LEFT_OUT: u32 = u32::MAX;

/// The number of points that a thread takes at a time.
const CHUNK: usize = 1024;

/// The smallest number of different points that are taken for the scan of a surface.
const FEWEST_POINTS: usize = 100;

/// The largest share of outliers among the points of a surface.
const MOST_OUTLIERS: f64 = 0.1;

/// How triangles are made of points.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Points closer than this, in the unit of the cloud, become one vertex. By default it is half
    /// of the spacing.
    pub spacing: Option<f64>,
}

impl Options {
    fn check(&self) -> Result<()> {
        self.spacing.map_or(Ok(()), |spacing| rules::length(spacing).map_err(of("spacing")))
    }
}

/// The triangles of a cloud.
#[derive(Debug, Clone)]
pub struct Triangulation {
    /// The triangles. The vertices are relative to the origin of the cloud and in its unit. They
    /// are where the surface is, not where a point was measured.
    pub soup: Soup,
    /// For each point of the cloud the vertex that stands for it, or [`LEFT_OUT`] for outliers and
    /// for points that no triangle uses.
    pub vertex_of: Vec<u32>,
    /// What was found.
    pub report: Report,
}

/// What was found in a cloud. Lengths are in its unit.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Report {
    /// The points of the cloud.
    pub points: usize,
    /// Points at exactly the place of an earlier one.
    pub duplicates: usize,
    /// Points that belong to no surface.
    pub outliers: usize,
    /// Points for which a vertex in their neighbourhood stands.
    pub thinned: usize,
    /// The median of the distances between neighbouring points.
    pub spacing: f64,
    /// The standard deviation of the points' noise along the normal. The vertices of the soup have
    /// less.
    pub noise: f64,
    /// The number of neighbours from which the surface at a point was found.
    pub neighbours: usize,
    /// The vertices of the soup.
    pub vertices: usize,
    /// The triangles of the soup.
    pub triangles: usize,
    /// Triangles that were dropped because their component is small.
    pub dropped: usize,
    /// Triangles at which the surface was cut, because it had one side only.
    pub one_sided: usize,
    /// What became of the grid of the scan.
    pub grid: GridUse,
}

/// Makes triangles of a cloud of points.
///
/// # Errors
/// - [`Error::Cloud`] if the points are not those of a surface.
/// - [`Error::Option`] if the spacing is not a length.
/// - What `progress` answers.
pub fn triangulate(
    cloud: &Points,
    options: &Options,
    progress: &mut Progress,
) -> Result<Triangulation> {
    options.check()?;
    match grid::triangulate_grid(cloud, options) {
        Ok(triangulation) => Ok(triangulation),
        Err(grid) => {
            let mut triangulation = scattered(cloud, options, progress)?;
            triangulation.report.grid = grid;
            Ok(triangulation)
        }
    }
}

/// The triangles of points without a grid.
fn scattered(cloud: &Points, _options: &Options, progress: &mut Progress) -> Result<Triangulation> {
    let ordered = Ordered::new(&cloud.positions);
    let points = &ordered.points;
    if points.len() < FEWEST_POINTS {
        return Err(fault(few(points.len())));
    }
    let near = Neighbours::new(points);
    let k = noise::neighbour_count(points, &near);
    progress(0.1)?;
    let lists = NearestLists::new(points, &near, k);
    drop(near);
    progress(0.4)?;
    let spacing = outliers::spacings(points, &lists);
    let mut outlier = outliers::lonely(&spacing, &lists);
    let first = project::all(points, &lists);
    let lines = first.iter().filter(|s| s.on_line).count();
    if lines as f64 > (1.0 - MOST_OUTLIERS) * points.len() as f64 {
        return Err(fault(CloudFault::Line));
    }
    let far = outliers::far(&first, &lists);
    for (i, is_far) in far.iter().enumerate() {
        outlier[i] |= *is_far && first[i].moved.abs() > spacing[i];
    }
    let outliers = outlier.iter().filter(|o| **o).count();
    if outliers as f64 > MOST_OUTLIERS * points.len() as f64 {
        return Err(fault(CloudFault::Outliers { outliers, points: points.len() }));
    }
    let noise = noise::deviation(points, &lists, &first, &outlier);
    let kept = thin::thin(&first, &spacing, noise, &lists, &outlier);
    let vertices = project::again(&kept.kept, points, &lists, &first, &outlier);
    drop(lists);
    progress(0.6)?;
    let stars = voronoi::VoronoiStars::new(&vertices);
    progress(0.8)?;
    let elected = votes::elect(&stars, &vertices);
    drop(stars);
    progress(0.9)?;
    let ManifoldMesh { mut mesh, dust, one_sided } = ManifoldMesh::new(&vertices, &elected);
    sides::face_scanner(&mut mesh, cloud, &ordered.first, &kept.kept);
    let mut of_spacing = spacing;
    let report = Report {
        points: cloud.len(),
        duplicates: cloud.len() - points.len(),
        outliers,
        thinned: points.len() - outliers - kept.kept.len(),
        spacing: ordered.frame.length(noise::median(&mut of_spacing).unwrap_or(0.0)),
        noise: ordered.frame.length(noise),
        neighbours: k,
        dropped: dust,
        one_sided,
        ..Report::default()
    };
    Ok(finished(cloud, &ordered, &kept.vertex, &mesh, report))
}

fn fault(fault: CloudFault) -> Error {
    Error::Cloud(fault)
}

fn few(points: usize) -> CloudFault {
    if points <= 1 { CloudFault::OnePlace } else { CloudFault::Few(points) }
}

/// The result, with only those vertices that triangles use.
fn finished(
    cloud: &Points,
    ordered: &Ordered,
    vertex: &[u32],
    mesh: &Mesh,
    mut report: Report,
) -> Triangulation {
    let mut soup = Soup { unit: cloud.unit, ..Soup::default() };
    let mut number = vec![LEFT_OUT; mesh.points.len()];
    mesh.triangles.iter().flatten().for_each(|v| number[v.index()] = 0);
    for (place, number) in mesh.points.iter().zip(&mut number).filter(|(_, n)| **n == 0) {
        *number = soup.points.len() as u32;
        soup.points.push(ordered.frame.outward(place));
    }
    for t in &mesh.triangles {
        soup.polygons.push(t.map(|v| number[v.index()]));
    }
    (report.vertices, report.triangles) = (soup.points.len(), soup.polygons.len());
    let of_point = |&i: &u32| match vertex[i as usize] {
        LEFT_OUT => LEFT_OUT,
        v => number[v as usize],
    };
    Triangulation { soup, vertex_of: ordered.number.iter().map(of_point).collect(), report }
}
