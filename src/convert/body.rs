//! The way from a body to a solid or a shell: mesh → smooth → fill → layout → net → patches → trim →
//! brep → deviation. A body is closed, or has gaps that are filled. A solid keeps its fills, and of a
//! shell they are cut out.

use formats::Brep;
use formats::brep::ShellId;

use super::stage::{Observer, Stage, within};
use super::{InputReport, Options, input, lengths};
use crate::adapt::Goal;
use crate::deviation::{self, Deviation, NetworkToScan};
use crate::error::BrepFault;
use crate::geometry::{Bound, Point};
use crate::layout::QuadLayout;
use crate::mesh::{Choice, Component, Components, FaceOrigin, Mesh, Patch};
use crate::spline::{Network, NetworkCut};
use crate::trim::network::{CutFault, NetworkRim};
use crate::{Error, Result, brep, fill, layout, net, patches, smooth, threads, trim};

/// What becomes of a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TargetShape {
    /// One face: the component is a sheet.
    Face,
    /// A shell of several faces with open boundaries: one face does not hold the component.
    Shell,
    /// A solid of several faces: the component is closed, or nearly so.
    Solid,
    /// A void in the solid before it: a closed component inside another one, facing the opposite way.
    Void,
}

/// A component is a body if flat caps over its gaps add less than this share to its area. Scanned
/// bodies have gaps of 0.1 to 3.5 %, pipes with open ends 11 to 13 %, busts with an open base 8 to
/// 25 %.
const GAPS: f64 = 0.05;

/// A component with several ends of similar size is a pipe if flat caps over all its loops have less than
/// this share of its area. A pipe as long as its diameter has 0.5. A plate with a hole, which one face
/// holds, has more than 1.
const PIPE: f64 = 0.5;

/// Two ends are similar if the cap of one has at least this share of the other's area. The holes in the
/// sheets of real scans have at most a twentieth of the outer loop's.
const SIMILAR: f64 = 0.25;

/// The distance in mm by which edges of a solid may be off its faces. They are the same polynomials,
/// so that only roundings remain.
const UNCERTAINTY: f64 = 1e-7;

/// The most rounds in which the layout is made finer. Where the scan tells no more about the shape, further
/// rounds do not help.
const FINER_ROUNDS: usize = 6;

/// The layout is not made finer if more than one in this number of faces is faulty. Then the parts of the
/// scan are finer than its triangles nearly everywhere, and finer layouts have more faults.
const MOST_FAULTY: usize = 5;

/// A face that leaves the scan by more than this multiple of the tolerance bridges a part that is narrower
/// than its quads. One in `FEW` faces, the farthest ones, are made smaller in a round, so that their
/// number grows only where it helps.
const FAR: f64 = 5.0;
const FEW: usize = 20;

/// The number of places in each span of a track at which the angle between its faces is measured.
const SEAM_PLACES: usize = 4;

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
    /// Whether at most the share `outliers` of the smoothed points exceeds the tolerance.
    pub fn tolerance_met(&self, outliers: f64) -> bool {
        let outliers = if self.tolerance_named { outliers } else { outliers.max(self.spared) };
        let most = outliers * self.fit_deviation.distances.len() as f64;
        self.fit_deviation.beyond(self.tolerance) as f64 <= most
    }
}

/// Says what a component becomes if nobody names a shape: a solid if it is closed or has small gaps, a
/// shell if it has handles or is a pipe with several ends, and otherwise a face.
///
/// # Errors
/// [`Error::Component`]: there is no such component.
pub fn shape(scan: &Components, component: Choice) -> Result<TargetShape> {
    Ok(shape_of(&scan.take(component)?))
}

/// The components that are voids in a component: closed ones inside it that face the opposite way.
///
/// # Errors
/// [`Error::Component`]: there is no such component.
pub fn voids(scan: &Components, component: Choice) -> Result<Vec<Choice>> {
    let solid = scan.take(component)?;
    let is_closed = |body: &Component| body.topology.orientable && body.topology.loops == 0;
    if !is_closed(&solid) {
        return Ok(Vec::new());
    }
    let others = (0..scan.sizeable()).filter(|&number| number != component.number());
    let mut voids = Vec::new();
    for choice in others.map(Choice::Number) {
        let other = scan.take(choice)?;
        if is_closed(&other)
            && other.is_inside_out() != solid.is_inside_out()
            && solid.encloses(&other)
        {
            voids.push(choice);
        }
    }
    Ok(voids)
}

/// The solids and shells of several conversions in one B-rep. A void becomes one of the last solid before
/// it.
///
/// # Errors
/// [`Error::Brep`] if a void is not in its solid.
pub fn joined_bodies(name: impl Into<String>, bodies: &[BodyConversion]) -> Result<Brep> {
    let mut all = Brep { name: name.into(), ..Brep::default() };
    for body in bodies {
        all.append(body.brep.clone());
        if let (TargetShape::Void, Some(last)) = (body.shape, all.solids.last_mut()) {
            last.voids.push(ShellId(all.shells.len() - 1));
        }
    }
    all.check().map_err(|fault| Error::Brep(BrepFault::Parts(fault)))?;
    Ok(all)
}

/// What one component becomes.
pub(super) fn shape_of(component: &Component) -> TargetShape {
    let topology = &component.topology;
    match topology.orientable {
        true if component.gap_share() < GAPS => TargetShape::Solid,
        true if topology.genus() > 0.0 || is_pipe(&component.cap_shares()) => TargetShape::Shell,
        _ => TargetShape::Face,
    }
}

/// Whether these shares of the area, largest first, are those of the caps of a pipe.
fn is_pipe(caps: &[f64]) -> bool {
    let [first, second, ..] = caps else { return false };
    caps.iter().sum::<f64>() < PIPE && *second > SIMILAR * first
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
    let goal = Goal::of(options, &measured.mesh, noise);
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

    let net_options =
        net::Options { tolerance, outliers: goal.outliers, max_control: options.knots.max_net };
    let gaps = Gaps::of(&patch, shape, tolerance, options);
    let Faces { network: own, cut, to_scan: face_to_scan, layout, net, irregular, .. } =
        faces(&patch.even(), &gaps, options.faces, &net_options, watch)?;
    let network = own.clone().scaled(mm);
    watch(Stage::Network(&network))?;
    let brep = match shape {
        TargetShape::Shell => {
            watch(Stage::NetworkTrim(&network, &cut))?;
            let accuracy = network.surfaces.iter().map(trim::edge_accuracy);
            brep::open(&network, &cut, &options.name, accuracy.fold(UNCERTAINTY, f64::max))?
        }
        TargetShape::Void => brep::void(&network, &options.name, UNCERTAINTY)?,
        _ => brep::closed(&network, &options.name, UNCERTAINTY)?,
    };
    watch(Stage::Brep)?;

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
        brep,
        shape,
        network,
        cut,
    };
    watch(Stage::Deviation)?;
    Ok(body)
}

/// The gaps that are cut out of the faces.
struct Gaps {
    rims: Vec<NetworkRim>,
    options: trim::Options,
}

impl Gaps {
    /// All gaps of a shell, and none of a solid.
    fn of(patch: &Patch, shape: TargetShape, tolerance: f64, options: &Options) -> Self {
        let triangles = patch.measured_triangles().map(|t| patch.mesh.triangles[t]).collect();
        let normals = Mesh { points: patch.mesh.points.clone(), triangles }.vertex_normals();
        let rim = |(hole, rim): (usize, &crate::mesh::boundary::Loop)| NetworkRim {
            of: Bound::Hole(hole),
            points: rim.iter().map(|&v| patch.mesh.point(v)).collect(),
            normals: rim.iter().map(|v| normals[v.index()]).collect(),
        };
        let rims: Vec<_> = match shape {
            TargetShape::Shell => patch.rims.iter().enumerate().map(rim).collect(),
            _ => Vec::new(),
        };
        let options = options.trim(tolerance, rims.iter().map(|rim| rim.points.as_slice()));
        Gaps { rims, options }
    }

    fn cut(&self, network: &Network) -> std::result::Result<NetworkCut, CutFault> {
        trim::network::cut(network, &self.rims, &self.options)
    }
}

/// The faces of a body, in the lengths of its mesh.
struct Faces {
    network: Network,
    cut: NetworkCut,
    /// Why the gaps cannot be cut out.
    uncut: Option<CutFault>,
    to_scan: NetworkToScan,
    layout: layout::Report,
    net: net::Report,
    irregular: usize,
}

/// Makes the faces of a filled body with even triangles. The layout is made finer where they turn over or
/// go through each other, and then, unless about so many faces are `wanted`, where they are far from the
/// scan.
fn faces(
    patch: &Patch,
    gaps: &Gaps,
    wanted: Option<usize>,
    options: &net::Options,
    watch: &mut Observer,
) -> Result<Faces> {
    let how = layout::Options { blocks: wanted, ..layout::Options::default() };
    let mut layout = layout::layout_with(&patch.mesh, &how, &mut within("layout", watch))?;
    let mut best: Option<Faces> = None;
    for round in 0..=FINER_ROUNDS {
        watch(Stage::Layout(layout.quads()))?;
        let (faces, faults) = faces_of(&layout, patch, gaps, options, watch)?;
        let blocks = match faults.first() {
            Some(_) if best.is_some() => break,
            Some(&(_, at)) => {
                let mut blocks: Vec<usize> = faults.iter().map(|fault| fault.0).collect();
                blocks.sort_unstable();
                blocks.dedup();
                if blocks.len() > faces.network.surfaces.len() / MOST_FAULTY
                    || round == FINER_ROUNDS
                {
                    let folds = Error::BodyFolds { count: faults.len(), at };
                    return Err(faces.uncut.map_or(folds, Error::from));
                }
                blocks
            }
            None => {
                let off = |faces: &Faces| faces.to_scan.deviation.max;
                if best.as_ref().is_some_and(|best| off(&faces) >= off(best)) {
                    break;
                }
                let far = faces.far(FAR * options.tolerance);
                best = Some(faces);
                if wanted.is_some() { Vec::new() } else { far }
            }
        };
        if blocks.is_empty() || !layout.split(&blocks, &mut within("layout", watch))? {
            break;
        }
    }
    best.ok_or(Error::Layout("no block of it can be made smaller"))
}

/// Makes the faces of a layout. Returns also those that turn over or go through each other, with places.
fn faces_of(
    layout: &QuadLayout,
    patch: &Patch,
    gaps: &Gaps,
    options: &net::Options,
    watch: &mut Observer,
) -> Result<(Faces, Vec<(usize, Point)>)> {
    let is_measured: Vec<bool> =
        patch.origin.iter().map(|&origin| origin == FaceOrigin::Measured).collect();
    let mut within = within("fit", watch);
    let (fitted, net) = net::fit_with(layout.quads(), patch, options, &mut within)?;
    let (network, extracted) = patches::extract(&fitted.mesh, &fitted.surface)?;
    let (cut, uncut) = match gaps.cut(&network) {
        Ok(cut) => (cut, None),
        Err(fault) => (NetworkCut::none(&network), Some(fault)),
    };
    let kept = cut.kept_places(&network);
    let to_scan =
        deviation::network_to_scan(&network, &kept, &fitted.mesh, &patch.mesh, &is_measured);
    let mut faults = to_scan.inverted.clone();
    match &uncut {
        // Without loops nobody knows which faults count.
        Some(fault) => faults = vec![(fault.surface, fault.at)],
        None => faults.extend(deviation::crossing_faces(&network, &kept)),
    }
    let (layout, irregular) = (layout.report(), extracted.irregular);
    Ok((Faces { network, cut, uncut, to_scan, layout, net, irregular }, faults))
}

impl Faces {
    /// The few faces that are farthest from the scan, and farther than `limit`.
    fn far(&self, limit: f64) -> Vec<usize> {
        let largest = &self.to_scan.largest;
        let mut far: Vec<usize> =
            (0..largest.len()).filter(|&face| largest[face] > limit).collect();
        far.sort_by(|&a, &b| largest[b].total_cmp(&largest[a]));
        far.truncate(largest.len().div_ceil(FEW));
        far
    }
}

fn seams(network: &Network) -> Seams {
    let mut angles = network.seam_angles(SEAM_PLACES);
    if angles.is_empty() {
        return Seams::default();
    }
    angles.sort_by(f64::total_cmp);
    let n = angles.len();
    let mean = angles.iter().sum::<f64>() / n as f64;
    let [p95, max] = [(n * 95).div_ceil(100), n].map(|k| angles[k - 1]);
    Seams { mean: mean.to_degrees(), p95: p95.to_degrees(), max: max.to_degrees() }
}
