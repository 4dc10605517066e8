//! What came in: the chosen component of a scan, looked at and made a disk.

use formats::scene::Placement;

use super::align::moved_place;
use super::estimate::{BodyEstimate, estimate};
use super::exact::{self, ExactEstimate};
use super::scanned;
use super::shape::{TargetShape, shape_and_reason};
use crate::convert::Options;
use crate::error::Result;
use crate::geometry::{Point, Vector};
use crate::mesh::{
    Choice, Component, Components, Disk, Handle, Mesh, Outer, RawPoints, Repairs, Topology,
    VertexRings, boundary,
};
use crate::noise::NoiseField;
use crate::stages::adapt::Goal;
use crate::stages::parameterize::is_ragged;
use crate::threads;

/// What came in.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct InputReport {
    /// The number of the component, where the largest one is 0.
    pub component: usize,
    /// Vertices of the chosen component.
    pub vertices: usize,
    /// Triangles of the chosen component.
    pub triangles: usize,
    /// Components of the scan.
    pub components: usize,
    /// Other components that lie in its holes, and in theirs, and come with it.
    pub islands: usize,
    /// Triangles of these, cleaned.
    pub island_triangles: usize,
    /// Triangles in the components left out.
    pub left_out: usize,
    /// Components left out that touch or overlap the chosen one.
    pub beside: Vec<usize>,
    /// Boundary loops of the chosen component.
    pub boundary_loops: usize,
    /// The lowest and the highest coordinates of the chosen component, in mm.
    pub bounds: [[f64; 3]; 2],
    /// What was repaired: kind and count.
    pub repairs: Repairs,
    /// The handles that were cut, in mm.
    pub handles: Vec<Handle>,
}

/// What a component of a scan is. Lengths are mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Inspection {
    /// Its counts, and what was repaired. Where the component is a disk, with
    /// what a conversion would take off its rims.
    pub input: InputReport,
    /// What kind of surface it is.
    pub topology: Topology,
    /// The length of each boundary loop and its number of vertices. Of a
    /// one-sided surface none are listed.
    pub loops: Vec<(f64, usize)>,
    /// Which of the loops is the outer one; `None` if there is none.
    pub outer: Option<usize>,
    /// Standard deviation of the noise along the normal.
    pub noise: f64,
    /// What a conversion makes of it; `None` if it can only be refused.
    pub shape: Option<TargetShape>,
    /// Why it becomes this shape, if nobody names one.
    pub reason: &'static str,
    /// About the tolerance that a conversion chooses if nobody names one.
    pub tolerance: f64,
    /// Whether the outer boundary is so ragged that a face gets a trim loop there. `None` if the
    /// component does not become a face.
    pub is_ragged: Option<bool>,
    /// The largest components, if there are several.
    pub pieces: Vec<PieceReport>,
    /// The exact faces that it has, if it is a clean mesh, or the scan of a part. There is then no other estimate.
    pub exact: Option<ExactEstimate>,
    /// An estimate of a solid or a shell. `None` for a face, or if a conversion fails before it has a
    /// layout.
    pub body: Option<BodyEstimate>,
}

/// One of several components. Lengths are mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PieceReport {
    /// Triangles.
    pub triangles: usize,
    /// The extent in x, y and z.
    pub size: [f64; 3],
    /// What kind of surface it is.
    pub topology: Topology,
}

/// The largest number of components that an inspection lists. Each takes as long as reading the mesh once,
/// at most.
const MOST_PIECES: usize = 12;

/// The largest components, if there are several.
fn pieces(scan: &Components) -> Result<Vec<PieceReport>> {
    let count = if scan.count() > 1 { scan.sizeable().min(MOST_PIECES) } else { 0 };
    let piece = |number: usize| {
        let piece = scan.take(Choice::Number(number))?;
        let [low, high] = piece.own_mesh().bounds();
        Ok(PieceReport {
            triangles: piece.own_mesh().triangles.len(),
            size: ((high - low) * piece.mm()).into(),
            topology: piece.topology.clone(),
        })
    };
    (0..count).map(piece).collect()
}

impl InputReport {
    fn new(scan: &Components, component: Choice, chosen: &Component) -> Self {
        InputReport {
            component: component.number(),
            vertices: chosen.own_mesh().points.len(),
            triangles: chosen.own_mesh().triangles.len(),
            components: scan.count(),
            islands: 0,
            island_triangles: 0,
            left_out: chosen.left_out,
            beside: scan.beside(component, chosen.own_mesh()),
            boundary_loops: chosen.topology.loops,
            bounds: chosen.own_mesh().bounds().map(|p| (scan.mm() * p.coords).into()),
            repairs: scan.repairs().clone(),
            handles: chosen.handles.iter().map(|handle| handle.scaled(scan.mm())).collect(),
        }
    }

    /// Counts the islands of the disk that was made of the component; `sizes`
    /// are the triangles of each of the scan's components.
    fn count_islands(&mut self, disk: &Disk, sizes: &[usize]) {
        self.islands = disk.islands.len();
        self.beside.retain(|&n| disk.islands.iter().all(|island| island.component != n));
        self.island_triangles = disk.islands.iter().map(|i| i.triangles).sum();
        self.left_out -= disk.islands.iter().map(|i| sizes[i.component]).sum::<usize>();
    }
}

/// Mesh → disk with holes, in the lengths of the mesh, as the options are.
pub(crate) fn disk(scan: &Components, options: &Options) -> Result<(Disk, InputReport)> {
    let chosen = scan.take(options.component)?;
    let mut input = InputReport::new(scan, options.component, &chosen);
    let disk = chosen.into_own_disk(options.outer(), &mut input.repairs)?;
    input.count_islands(&disk, &scan.sizes());
    Ok((disk, input))
}

/// Mesh → body, in the lengths of the mesh. A solid faces outwards, and a void inwards. A shell keeps
/// the sides of the scan.
pub(crate) fn body(
    scan: &Components,
    shape: TargetShape,
    options: &Options,
) -> Result<(Disk, InputReport)> {
    let chosen = scan.take(options.component)?;
    let mut input = InputReport::new(scan, options.component, &chosen);
    let mut body = chosen.into_own_body(&mut input.repairs)?;
    match shape {
        TargetShape::Solid => body.turn(true, &mut input.repairs),
        TargetShape::Void => body.turn(false, &mut input.repairs),
        TargetShape::Shell | TargetShape::Face => {}
    }
    Ok((body, input))
}

/// Mesh → body with all its handles, in the lengths of the mesh. It faces outwards, also where it is a void. An open
/// one keeps the sides of the scan.
pub(crate) fn whole_body(
    scan: &Components,
    component: Choice,
    shape: TargetShape,
    options: &Options,
) -> Result<(Disk, InputReport)> {
    let chosen = match options.handles {
        Some(_) => scan.take(component)?,
        None => scan.take_whole(component)?,
    };
    let mut input = InputReport::new(scan, component, &chosen);
    let mut body = chosen.into_own_body(&mut input.repairs)?;
    match shape {
        TargetShape::Void => body.turn(true, &mut Repairs::new()),
        TargetShape::Shell | TargetShape::Face => {}
        TargetShape::Solid => body.turn(true, &mut input.repairs),
    }
    Ok((body, input))
}

/// Components of a scan as they were measured. Lengths are mm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Measured {
    /// Their points and triangles.
    pub mesh: Mesh,
    /// The points of the cloud that the mesh was made of, outliers left out; `None` if the scan is
    /// a mesh.
    pub points: Option<Vec<Point>>,
    /// Triangles in the components left out.
    pub left_out: usize,
}

impl Measured {
    /// The same where a conversion has put it ([`Conversion::placement`](super::Conversion::placement)).
    #[must_use]
    pub fn placed(mut self, by: &Placement) -> Self {
        let points = self.mesh.points.iter_mut().chain(self.points.iter_mut().flatten());
        points.for_each(|p| *p = moved_place(*p, by));
        self
    }

    /// The same moved by a vector.
    #[must_use]
    pub fn translated(mut self, by: [f64; 3]) -> Self {
        let points = self.mesh.points.iter_mut().chain(self.points.iter_mut().flatten());
        points.for_each(|p| *p += Vector::from(by));
        self
    }
}

/// The points and triangles of components as they were measured: those that a
/// conversion would take, islands included, or, where a component cannot be
/// converted, all that it has.
///
/// # Errors
/// There is no such component.
pub fn measured(scan: &Components, components: &[Choice], outer: Outer) -> Result<Measured> {
    threads::run(None, || gather(scan, components, outer))?
}

fn gather(scan: &Components, components: &[Choice], outer: Outer) -> Result<Measured> {
    let mm = scan.mm();
    let mut mesh = Mesh { points: Vec::new(), triangles: Vec::new() };
    let mut left_out = scan.sizes();
    for &component in components {
        let chosen = scan.take(component)?;
        left_out[component.number()] = 0;
        if chosen.topology.check_disk().is_err() {
            mesh.append(chosen.own_mesh());
            continue;
        }
        let disk = chosen.into_own_disk(outer.in_lengths(mm), &mut Repairs::new())?;
        mesh.append(&disk.mesh);
        disk.islands.iter().for_each(|island| left_out[island.component] = 0);
    }
    let points = scan.raw_points().map(|_| {
        let raw = scan.measured_points(&mesh.points).points;
        raw.iter().map(|p| mm * p).collect()
    });
    Ok(Measured { mesh: mesh.scaled(mm), points, left_out: left_out.iter().sum() })
}

/// Looks at one component of a scan, of whatever topology it is.
///
/// # Errors
/// There is no such component.
pub fn inspect(scan: Components, component: Choice, outer: Outer) -> Result<Inspection> {
    threads::run(None, || look_at(scan, component, outer))?
}

/// An estimate of a component that becomes a body.
fn body_estimate(scan: &Components, component: Choice, shape: TargetShape) -> Option<BodyEstimate> {
    if shape == TargetShape::Face {
        return None;
    }
    let body = scan.take(component).ok()?.into_own_body(&mut Repairs::new()).ok()?;
    let raw = scan.raw_points().map_or(0.0, RawPoints::noise);
    let noise = raw.max(NoiseField::new(&body.mesh, &VertexRings::new(&body.mesh)).deviation);
    let estimate = estimate(body, shape, noise).ok()?;
    let handles = estimate.handles.iter().map(|handle| handle.scaled(scan.mm())).collect();
    Some(BodyEstimate { handles, ..estimate })
}

fn look_at(scan: Components, component: Choice, outer: Outer) -> Result<Inspection> {
    let exact = match exact::estimate(&scan, component)? {
        None => scanned::estimate(&scan, component)?,
        found => found,
    };
    let chosen = match exact {
        Some(_) => scan.take_whole(component)?,
        None => scan.take(component)?,
    };
    let mut input = InputReport::new(&scan, component, &chosen);
    let sizes = scan.sizes();
    let raw_noise = scan.raw_points().map_or(0.0, RawPoints::noise);
    let (own, reason) = shape_and_reason(&chosen);
    let shape = exact.as_ref().and_then(|exact| exact.shape).unwrap_or(own);
    let is_refused = shape == TargetShape::Face && !chosen.topology.is_disk();
    let shape = (!is_refused).then_some(shape);
    let body = match exact {
        Some(_) => None,
        None => shape.and_then(|shape| body_estimate(&scan, component, shape)),
    };
    let pieces = pieces(&scan)?;
    drop(scan);
    let (mesh, mm) = (chosen.own_mesh(), chosen.mm());
    let rings = if chosen.topology.orientable { chosen.loops() } else { Vec::new() };
    let outer_loop = (!rings.is_empty()).then(|| chosen.outer(outer, &rings));
    let found = NoiseField::new(mesh, &VertexRings::new(mesh));
    let noise = found.deviation.max(raw_noise);
    let is_face = shape == Some(TargetShape::Face);
    let inspection = Inspection {
        topology: chosen.topology.clone(),
        loops: rings.iter().map(|ring| (mm * boundary::length(mesh, ring), ring.len())).collect(),
        outer: outer_loop,
        noise: mm * noise,
        shape,
        reason,
        tolerance: mm * Goal::of_scan(mesh, noise, found.is_visible).tolerance,
        is_ragged: outer_loop.filter(|_| is_face).map(|outer| is_ragged(mesh, &rings[outer])),
        pieces,
        exact,
        body,
        input: input.clone(),
    };
    if inspection.topology.is_disk() {
        let disk = chosen.into_disk(outer, &mut input.repairs)?;
        input.count_islands(&disk, &sizes);
    }
    Ok(Inspection { input, ..inspection })
}
