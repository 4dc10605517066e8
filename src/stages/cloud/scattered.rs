//! Triangles of points without a grid: the order of the steps.

use formats::{Points, Soup};

use super::average::Averaged;
use super::layers::{self, AreJoined, Layers};
use super::manifold::ManifoldMesh;
use super::nearest_lists::NearestLists;
use super::order::Ordered;
use super::project::SurfacePoint;
use super::thin::KeptPoints;
use super::voronoi::VoronoiStars;
use super::{LEFT_OUT, Options, Report, Triangulation, noise, outliers, project, sides, votes};
use crate::error::{CloudFault, Error, Result};
use crate::geometry::Point;
use crate::mesh::{Mesh, Neighbours};
use crate::progress::Progress;
use crate::rules::LEAST_POINTS;
use crate::statistics::median;

/// The largest share of outliers among the points of a surface. A point in ten that is far from
/// its neighbours means that these are not a surface either.
const MOST_OUTLIERS: f64 = 0.1;

/// Vertices go back to where they were measured if the noise is at most this share of the spacing.
/// With more noise, triangles stand so steeply that smoothing cannot find neighbours along them. On
/// the relief, the face's distance from the true surface is then 0.66 (noise of 0.28 spacings), 0.83
/// (0.45), 0.85 (0.5), 1.12 (0.8), and 1.5 (0.9) of that with vertices on the surface.
const MOST_ROUGH: f64 = 0.6;

/// The points of a cloud, and where they are on the surface.
struct SurfacePoints {
    lists: NearestLists,
    spacing: Vec<f64>,
    surface: Vec<SurfacePoint>,
    /// Points that belong to no surface.
    outlier: Vec<bool>,
    /// The distance between layers, if there are several.
    layers: Option<f64>,
    /// Outliers, and other points with which the noise should not be measured.
    suspect: Vec<bool>,
}

/// Makes triangles of points without a grid. Where they are too dense, triangles are made of the means of cells.
pub(super) fn triangulate(
    cloud: &Points,
    options: &Options,
    progress: &mut Progress,
) -> Result<Triangulation> {
    let ordered = Ordered::new(&cloud.positions);
    let points = ordered.points.len();
    match (Averaged::new(cloud, &ordered, options), options.most_places) {
        (None, Some(places)) if points > places => {
            Err(Error::Cloud(CloudFault::Crowded { points, places }))
        }
        (None, _) => of_points(cloud, &ordered, &|_| 1, options, progress),
        (Some(averaged), _) => {
            let means = Ordered::new(&averaged.means.positions);
            let count = |mean: usize| averaged.count[mean] as usize;
            let made = of_points(&averaged.means, &means, &count, options, progress)?;
            Ok(averaged.of_cloud(made, cloud, &ordered))
        }
    }
}

/// Makes triangles of points, each of which stands for `count` measured ones.
fn of_points(
    cloud: &Points,
    ordered: &Ordered,
    count: &dyn Fn(usize) -> usize,
    options: &Options,
    progress: &mut Progress,
) -> Result<Triangulation> {
    let points = &ordered.points;
    if points.len() < LEAST_POINTS {
        let fault =
            if points.len() > 1 { CloudFault::Few(points.len()) } else { CloudFault::OnePlace };
        return Err(Error::Cloud(fault));
    }
    let found = SurfacePoints::new(cloud, ordered, progress)?;
    let deviation = noise::deviation(points, &found.lists, &found.surface, &found.suspect);
    let apart = options.spacing.map_or(0.0, |spacing| ordered.frame.work_length(spacing));
    let kept = KeptPoints::new(
        &found.surface,
        &found.spacing,
        deviation,
        &found.lists,
        &found.outlier,
        apart,
    );
    let spacing = found.spacing_along_surface();
    let measured_in = |is_counted: &dyn Fn(usize) -> bool| {
        let counted = (0..points.len()).filter(|&i| is_counted(i));
        counted.map(|i| count(ordered.first[i] as usize)).sum::<usize>()
    };
    let mut report = Report {
        points: cloud.len(),
        duplicates: cloud.len() - points.len(),
        outliers: measured_in(&|i| found.outlier[i]),
        spacing: ordered.frame.length(spacing),
        noise: ordered.frame.length(deviation),
        layers: found.layers.map(|distance| ordered.frame.length(distance)),
        neighbours: found.lists.count(),
        ..Report::default()
    };
    report.thinned = measured_in(&|_| true) - report.outliers - kept.points.len();
    // A triangle has three vertices.
    if kept.points.len() < 3 {
        return Err(Error::Cloud(CloudFault::NoTriangle));
    }
    let vertices = found.again(points, &kept.points);
    let is_smooth = deviation > MOST_ROUGH * spacing;
    let measured = if is_smooth { Vec::new() } else { measured(points, &kept, &vertices) };
    let SurfacePoints { layers, lists, .. } = found;
    // Only layers need the lists any longer.
    let lists = layers.map(|_| lists);
    progress(7.0 / 10.0)?;
    let mut mesh = mesh_of(&vertices, (&kept, lists.as_ref()), &mut report, progress)?;
    sides::face_scanner(&mut mesh, cloud, &ordered.first, &kept.points);
    Ok(finished(cloud, ordered, (&kept, &measured), &mesh, report))
}

impl SurfacePoints {
    /// Projects points onto their surface, and finds outliers.
    fn new(cloud: &Points, ordered: &Ordered, progress: &mut Progress) -> Result<Self> {
        let points = &ordered.points;
        let near = Neighbours::new(points);
        let few = noise::COUNTS[0];
        let facing = sides::facing(cloud, ordered, &near, few);
        let layers = Layers::new(points, &near, facing, few);
        let count = noise::neighbour_count(points, &layers);
        progress(1.0 / 10.0)?;
        let lists = NearestLists::new(points, &layers, count);
        let layers = layers.distance;
        drop(near);
        progress(3.0 / 10.0)?;
        let spacing = outliers::spacings(points, &lists);
        let mut outlier = outliers::lonely(&spacing, &lists);
        let surface = project::all(points, &lists);
        if share(surface.iter().map(|s| s.on_line)) > 1.0 - MOST_OUTLIERS {
            return Err(Error::Cloud(CloudFault::Line));
        }
        let [far, mut suspect] = outliers::far(&surface, &lists);
        for (i, is_outlier) in outlier.iter_mut().enumerate() {
            *is_outlier |= far[i] && surface[i].moved.abs() > spacing[i];
            suspect[i] |= *is_outlier;
        }
        if share(outlier.iter().copied()) > MOST_OUTLIERS {
            let outliers = outlier.iter().filter(|is| **is).count();
            return Err(Error::Cloud(CloudFault::Outliers { outliers, points: points.len() }));
        }
        progress(0.5)?;
        Ok(SurfacePoints { lists, layers, spacing, surface, outlier, suspect })
    }

    /// The median spacing of the projected points. That of the measured ones is larger, because it
    /// goes through the noise.
    fn spacing_along_surface(&self) -> f64 {
        let places: Vec<Point> = self.surface.iter().map(|s| s.place).collect();
        median(&mut outliers::spacings(&places, &self.lists)).unwrap_or(0.0)
    }

    /// The kept points on the surface of their neighbours without outliers.
    fn again(&self, points: &[Point], kept: &[u32]) -> Vec<SurfacePoint> {
        project::again(kept, points, &self.lists, &self.surface, &self.outlier)
    }
}

/// Each vertex at the mean height of the points that it stands for. It stays where it is along its
/// tangent plane, so that triangles do not fold. Every point counts once. If the points that were
/// kept counted more, their heights would add up, because their order depends on their heights.
fn measured(points: &[Point], kept: &KeptPoints, vertices: &[SurfacePoint]) -> Vec<Point> {
    let mut heights = vec![(0.0, 0u32); vertices.len()];
    for (point, &vertex) in points.iter().zip(&kept.vertex) {
        let Some(at) = vertices.get(vertex as usize) else { continue };
        let (sum, count) = &mut heights[vertex as usize];
        *sum += (point - at.place).dot(&at.normal);
        *count += 1;
    }
    let place = |(at, (sum, count)): (&SurfacePoint, (f64, u32))| {
        at.place + sum / f64::from(count.max(1)) * at.normal
    };
    vertices.iter().zip(heights).map(place).collect()
}

/// The share of values that are true.
fn share(values: impl ExactSizeIterator<Item = bool>) -> f64 {
    let count = values.len();
    values.filter(|is| *is).count() as f64 / count as f64
}

/// The mesh of the triangles on which the vertices agree.
fn mesh_of(
    vertices: &[SurfacePoint],
    (kept, lists): (&KeptPoints, Option<&NearestLists>),
    report: &mut Report,
    progress: &mut Progress,
) -> Result<Mesh> {
    let point = |v: usize| kept.points[v];
    let joined = lists.map(|lists| {
        move |v: usize, w: u32| layers::are_joined(lists, point(v), point(w as usize))
    });
    let stars = VoronoiStars::new(vertices, joined.as_ref().map(|joined| joined as &AreJoined<'_>));
    progress(8.0 / 10.0)?;
    let elected = votes::elect(&stars, vertices);
    drop(stars);
    progress(9.0 / 10.0)?;
    let made = ManifoldMesh::new(vertices, &elected);
    if made.mesh.triangles.is_empty() {
        return Err(Error::Cloud(CloudFault::NoTriangle));
    }
    (report.dropped, report.one_sided) = (made.dust, made.one_sided);
    Ok(made.mesh)
}

/// The result, with only those vertices that triangles use.
fn finished(
    cloud: &Points,
    ordered: &Ordered,
    (kept, places): (&KeptPoints, &[Point]),
    mesh: &Mesh,
    mut report: Report,
) -> Triangulation {
    let mut soup = Soup { unit: cloud.unit, ..Soup::default() };
    let mut is_used = vec![false; mesh.points.len()];
    mesh.triangles.iter().flatten().for_each(|v| is_used[v.index()] = true);
    let mut number = vec![LEFT_OUT; mesh.points.len()];
    let mut measured = Vec::new();
    for v in (0..mesh.points.len()).filter(|&v| is_used[v]) {
        number[v] = soup.points.len() as u32;
        soup.points.push(ordered.frame.outward(&mesh.points[v]));
        measured.extend(places.get(v).map(|place| ordered.frame.outward(place)));
    }
    for t in &mesh.triangles {
        soup.polygons.push(t.map(|v| number[v.index()]));
    }
    (report.vertices, report.triangles) = (soup.points.len(), soup.polygons.len());
    let of_point = |&i: &u32| match kept.vertex[i as usize] {
        LEFT_OUT => LEFT_OUT,
        v => number[v as usize],
    };
    let vertex_of = ordered.number.iter().map(of_point).collect();
    Triangulation { soup, vertex_of, measured, report }
}
