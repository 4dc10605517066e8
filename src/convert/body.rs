//! The way from a body to a solid or a shell: mesh → smooth → fill → layout → net → patches →
//! refine → trim → brep → deviation. A body is closed, or has gaps that are filled. A solid keeps its
//! fills, and of a shell they are cut out.

use formats::Brep;
use formats::brep::ShellId;

use super::conversion::{farther, placed, worst};
use super::faces::{Faces, Gaps, SEAM_PLACES, faces};
use super::stage::{Observer, Stage, within};
use super::{InputReport, Options, TargetShape, goal, input, lengths};
use crate::adapt::Goal;
use crate::deviation::{self, Deviation, NetworkToScan};
use crate::error::BrepFault;
use crate::mesh::{Components, VertexMap};
use crate::spline::{Network, NetworkCut};
use crate::trim::EDGE_ACCURACY;
use crate::words::plural;
use crate::{Error, Result, brep, fill, layout, net, smooth, threads, trim};

/// A component that became a solid or a shell. Lengths are in mm.
#[derive(Debug)]
#[non_exhaustive]
pub struct BodyConversion {
    /// The boundary representation, which the writers take.
    pub brep: Brep,
    /// Solid or shell.
    pub shape: TargetShape,
    /// The surfaces and their sides.
    pub network: Network,
    /// The loops along the gaps, and the faces that they leave.
    pub cut: NetworkCut,
    /// What came in.
    pub input: InputReport,
    /// What smoothing did.
    pub smooth: smooth::Report,
    /// The gaps that were filled.
    pub fill: fill::Report,
    /// The quads.
    pub layout: layout::Report,
    /// The fit of the surface.
    pub net: net::Report,
    /// The number of irregular vertices.
    pub irregular: usize,
    /// The tolerance that holds.
    pub tolerance: f64,
    /// Whether the caller named it.
    pub tolerance_named: bool,
    /// The share of points that may miss a tolerance that nobody named.
    pub spared: f64,
    /// Standard deviation of the noise of the measured points along the normal.
    pub noise: f64,
    /// Deviation of the smoothed points; the tolerance is held against it.
    pub fit_deviation: Deviation,
    /// Deviation of the points as they were measured.
    pub deviation: Deviation,
    /// How far the faces are from the triangles of the smoothed scan.
    pub face_to_scan: NetworkToScan,
    /// The angles between neighbouring faces.
    pub seams: Seams,
    /// The enclosed volume of a solid in mm³. That of a void is negative.
    pub volume: Option<f64>,
    /// Where the places of the conversion are measured from in the scan's own frame, in mm: zero,
    /// or a point near a cloud that is far from zero.
    pub origin: [f64; 3],
    /// Which point each vertex of the scan became.
    vertices: VertexMap,
}

/// The angles between the normals of neighbouring faces along their common sides, in degrees.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seams {
    /// The mean.
    pub mean: f64,
    /// The 95th percentile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

impl BodyConversion {
    /// The point that a vertex of the scan became, as
    /// [`Conversion::point_of`](crate::Conversion::point_of).
    pub fn point_of(&self, vertex: usize) -> Option<usize> {
        self.vertices.point_of(vertex)
    }

    /// Whether at most the share `outliers` of the smoothed points exceeds the tolerance. If it is named,
    /// this holds for samples of the faces, too, which may leave flat triangles by their chord error
    /// besides.
    pub fn tolerance_met(&self, outliers: f64) -> bool {
        let outliers = if self.tolerance_named { outliers } else { outliers.max(self.spared) };
        let keeps = |beyond: usize, all: usize| beyond as f64 <= outliers * all as f64;
        let back = &self.face_to_scan;
        keeps(self.fit_deviation.beyond(self.tolerance), self.fit_deviation.distances.len())
            && (!self.tolerance_named || keeps(back.beyond, back.deviation.distances.len()))
    }

    /// How many points, and how much of the faces, are beyond the tolerance, and the worst.
    pub fn beyond(&self) -> String {
        let shape = self.shape.word();
        let part = |beyond: usize, of: &str, from: &str, all: &Deviation| {
            farther(beyond, of, self.tolerance, from) + &worst(all.max, all.max_at)
        };
        let mut parts = Vec::new();
        let points = self.fit_deviation.beyond(self.tolerance);
        if points > 0 {
            let of = plural(self.fit_deviation.distances.len(), "point");
            parts.push(part(points, &of, &format!("the {shape}"), &self.fit_deviation));
        }
        let back = &self.face_to_scan;
        if self.tolerance_named && back.beyond > 0 {
            let of = format!("{} on the {shape}", plural(back.deviation.distances.len(), "place"));
            let from = "the scan's triangles and their chord error";
            parts.push(part(back.beyond, &of, from, &back.deviation));
        }
        parts.join(", and ")
    }
}

/// The solids and shells of several conversions in one B-rep. A void becomes one of the last solid before
/// it.
///
/// # Errors
/// [`Error::Brep`] if a void is not in its solid.
pub fn joined_bodies(name: impl Into<String>, bodies: &[BodyConversion]) -> Result<Brep> {
    let description = bodies.first().map_or(String::new(), |body| body.brep.description.clone());
    let mut all = Brep { name: name.into(), description, ..Brep::default() };
    for body in bodies {
        all.append(body.brep.clone());
        if let (TargetShape::Void, Some(last)) = (body.shape, all.solids.last_mut()) {
            last.voids.push(ShellId(all.shells.len() - 1));
        }
    }
    all.check().map_err(|fault| Error::Brep(BrepFault::Parts(fault)))?;
    Ok(all)
}

/// Converts one component of a scan to a solid or to a shell. `watch` is as for
/// [`convert_component`](crate::convert_component).
///
/// # Errors
/// What stops a stage, or what `watch` answers. [`Error::Layout`] and [`Error::BodyFolds`] if no
/// sound faces were found. [`Error::Input`] if `shape` is a face.
pub fn convert_body(
    scan: &Components,
    shape: TargetShape,
    options: &Options,
    watch: &mut Observer,
) -> Result<BodyConversion> {
    if shape == TargetShape::Face {
        return Err(Error::Input("a body becomes a solid, a void or a shell, and not a face"));
    }
    threads::run(options.threads, || {
        let mut shown = lengths::Shown::new(watch, scan.mm());
        let own = options.in_lengths(scan.mm());
        let body = body(scan, shape, &own, &mut |stage| shown.see(stage));
        body.map_err(|error| shown.in_mm(error).with_named(options))
    })?
}

fn body(
    scan: &Components,
    shape: TargetShape,
    options: &Options,
    watch: &mut Observer,
) -> Result<BodyConversion> {
    let mm = scan.mm();
    let (measured, input) = input::body(scan, shape, options)?;
    watch(Stage::Mesh(&measured))?;
    let (smoothed, smooth) =
        smooth::smooth_with(&measured, &options.smooth, &mut within("smooth", watch))?;
    watch(Stage::Smooth(&smoothed))?;
    let noise = scan.raw_points().map_or(smooth.noise, |raw| raw.noise().max(smooth.noise));
    let goal = Goal::of(options, &measured.mesh, noise, smooth.is_noisy);
    let tolerance = options.tolerance.unwrap_or(goal.tolerance);
    let fill_options =
        fill::Options { support: smooth.h, noise: smooth.noise, ..options.fill.clone() };
    let points = &measured.mesh.points;
    let (patch, fill) = if shape == TargetShape::Shell {
        fill::fill_of_shell(smoothed, points, &fill_options, &mut within("fill", watch))?
    } else {
        fill::fill_with(smoothed, points, &fill_options, &mut within("fill", watch))?
    };
    watch(Stage::Fill(&patch))?;

    let is_clean = !goal.named && !smooth.is_noisy;
    let facets = if is_clean { goal::of_facets(&measured.mesh) } else { 0.0 };
    let net_options = net::Options {
        tolerance: tolerance.max(facets),
        outliers: goal.outliers,
        max_control: options.knots.max_net,
    };
    let gaps = Gaps::of(&patch, shape, tolerance, options);
    let Faces { network: own, cut, to_scan: face_to_scan, layout, net, irregular, .. } =
        faces(&patch.even(), &gaps, options.faces, &net_options, goal.named, watch)?;
    let network = own.clone().scaled(mm);
    watch(Stage::Network(&network))?;
    let brep = match shape {
        TargetShape::Shell => {
            watch(Stage::NetworkTrim(&network, &cut))?;
            let accuracy = network.surfaces.iter().map(trim::edge_accuracy);
            brep::open(&network, &cut, &options.name, accuracy.fold(EDGE_ACCURACY, f64::max))?
        }
        TargetShape::Void => brep::void(&network, &options.name, EDGE_ACCURACY)?,
        _ => brep::closed(&network, &options.name, EDGE_ACCURACY)?,
    };
    watch(Stage::Brep)?;

    let origin = scan.raw_points().map_or([0.0; 3], |raw| raw.origin().map(|x| mm * x));
    let smoothed = &patch.mesh.points[..patch.measured];
    let raw = scan.measured_points(&measured.mesh.points);
    let volume = || (0..brep.shells.len()).map(|shell| brep.volume(ShellId(shell))).sum();
    let body = BodyConversion {
        volume: (shape != TargetShape::Shell).then(volume),
        seams: seams(&network),
        input,
        smooth: smooth.scaled(mm),
        fill: fill.scaled(mm),
        layout: layout.scaled(mm),
        net: net.scaled(mm),
        irregular,
        tolerance: mm * tolerance,
        tolerance_named: goal.named,
        spared: goal.outliers,
        noise: mm * noise,
        fit_deviation: deviation::of_network(&own, &cut, smoothed).scaled(mm),
        deviation: deviation::of_network(&own, &cut, &raw.points).scaled(mm),
        face_to_scan: face_to_scan.scaled(mm),
        brep: placed(brep, origin, options.keeps_origin),
        origin,
        vertices: raw.map,
        shape,
        network,
        cut,
    };
    watch(Stage::Deviation)?;
    Ok(body)
}

fn seams(network: &Network) -> Seams {
    let places = network.seams(SEAM_PLACES).into_iter();
    let mut angles: Vec<f64> = places.map(|place| place.angle).collect();
    if angles.is_empty() {
        return Seams::default();
    }
    angles.sort_by(f64::total_cmp);
    let n = angles.len();
    let mean = angles.iter().sum::<f64>() / n as f64;
    let [p95, max] = [(n * 95).div_ceil(100), n].map(|k| angles[k - 1]);
    Seams { mean: mean.to_degrees(), p95: p95.to_degrees(), max: max.to_degrees() }
}
