//! The fit of one smooth surface to a whole scan.
//!
//! A quad mesh on the scan and the points of the scan go in. A [`Net`] comes out: the control points
//! of a Catmull–Clark surface at the vertices of the quad mesh, which may have been divided
//! further. The control points minimize the squared distances of the points from the surface at
//! their foot points, and the squared second differences of the net (fairing). Foot points and
//! control points are found in turn (Hoppe et al., "Piecewise smooth surface reconstruction", 1994;
//! Ma, Zhao, "A surface approximation by subdivision", 2004).

mod feet;
mod inverted;
mod solve;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::geometry::{Point, Uv, Vector};
use crate::mesh::{Patch, QuadMesh};
use crate::progress::{self, Progress};
use crate::spline::Samples;
use crate::spline::subdivision::{QuadPlace, SubdivisionSurface, limit_point};
use feet::{Feet, QuadFoot};
use solve::NetEquations;

/// The options of the fit.
#[derive(Debug, Clone)]
pub struct Options {
    /// The distance in mm that points may have from the surface. Quads are divided until this holds.
    pub tolerance: f64,
    /// The share of points that may exceed the tolerance.
    pub outliers: f64,
    /// The most quads along a side of a block to which quads are divided.
    pub max_side: usize,
}

/// The results of the fit. Lengths are in mm.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Report {
    /// The number of control points.
    pub control_points: usize,
    /// The number of quads along a side of a block.
    pub side: usize,
    /// The root mean square of the distances of the measured points from the surface.
    pub rms: f64,
    /// The share of measured points whose distance exceeds the tolerance.
    pub beyond: f64,
    /// The number of quads on which the surface is turned over somewhere.
    pub inverted: usize,
    /// The number of measured points without a foot point whose normal agrees.
    pub without_foot: usize,
}

/// A subdivision surface over a quad mesh in blocks.
#[derive(Debug, Clone)]
pub struct Net {
    /// The quad mesh. Its points are the control points, and its normals say how the scan faces at the
    /// vertices.
    pub mesh: QuadMesh,
    /// The structure of the surface.
    pub surface: SubdivisionSurface,
}

/// A net is made finer only if it gets at least five quads along a side for four, because less is not worth
/// another fit.
const FINER: usize = 5;
const COARSER: usize = 4;

/// The number of rounds of foot points and control points. Later rounds change the rms of smooth
/// bodies by less than a hundredth.
const ROUNDS: usize = 4;

/// The number of steps that bring the first surface to the vertices of the quads. Each step halves the
/// distance or better. Without them thin parts shrink, and points find feet on their other side.
const INTERPOLATIONS: usize = 5;

/// The most rounds in which fairing grows where the surface is turned over. Each makes it eight times
/// as strong, and after eight rounds it flattens everything.
const FIRMER_ROUNDS: usize = 8;

/// The factor by which a net becomes firmer where it is turned over. Smaller factors take more rounds, and
/// larger ones flatten more than is needed.
const FIRMER: f64 = 8.0;

/// The weight of a point that fills a hole, beside that of a measured point. It is small because
/// the fill was not measured, and not zero because the surface must follow it.
const FILLED: f64 = 0.05;

/// The weight of a point on a measured triangle between measured points, beside that of these. It is small because
/// the triangle is a chord of a curved surface. With a weight of 1, a ring of 2,560 noisy points is 0.03 mm too thin,
/// which is over half of its noise; with 0.1 it is 0.010 mm, and with 0.03 0.007 mm. It is not zero because the surface
/// must follow large flat triangles.
const BETWEEN: f64 = 0.1;

/// The number of measured points that a control point needs at least if a net is made finer. With fewer points,
/// control points follow noise and flat triangles instead of the shape.
const POINTS_OF_CONTROL: usize = 2;

impl Net {
    /// Returns an error if the quads are not closed or not regular enough.
    fn new(mesh: QuadMesh) -> Result<Self> {
        if mesh.normals.len() != mesh.points.len() {
            return Err(Error::Input("a quad mesh has not one normal for each point"));
        }
        let surface = SubdivisionSurface::new(&mesh.quads).ok_or(Error::Input(
            "a quad mesh is not closed or has quads with two irregular vertices",
        ))?;
        Ok(Net { mesh, surface })
    }

    /// The points of the surface at the vertices of the quad mesh.
    fn limit_points(&self) -> Vec<Point> {
        let control = self.control();
        let limit = |v: usize| {
            let (quad, k) = self.surface.corner(v.into());
            limit_point(&self.surface.ring(quad, k), &control)
        };
        (0..control.len()).into_par_iter().map(limit).collect()
    }

    /// Quads on the surface in blocks of `side` × `side`.
    fn with_side(&self, side: usize) -> QuadMesh {
        let (quads, places) = self.mesh.with_side(side);
        let control = self.control();
        let place = |scratch: &mut Vec<[f64; 3]>, &(block, at): &(usize, Uv)| {
            self.on_block(&control, block, at, scratch)
        };
        let places = places.par_iter().map_init(Vec::new, place);
        let (points, normals) = places.unzip();
        QuadMesh { points, normals, quads, side }
    }

    /// The point and the unit normal of the surface at a place of a block.
    fn on_block(
        &self,
        control: &[Vector],
        block: usize,
        at: Uv,
        scratch: &mut Vec<[f64; 3]>,
    ) -> (Point, Vector) {
        let (quad, within) = self.mesh.within(block, at);
        // At a corner the derivatives may vanish.
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        if let Some(k) = corners.iter().position(|&(x, y)| within == Uv::new(x, y)) {
            let point = limit_point(&self.surface.ring(quad, k), control);
            return (point, self.surface.limit_normal(quad, k, control));
        }
        let [p, du, dv] = self.surface.jet(control, QuadPlace { quad, at: within }, scratch);
        (Point::from(p), du.cross(&dv).try_normalize(0.0).unwrap_or_default())
    }

    /// Moves the control points so that the surface at the vertices comes nearer to the anchors (Lin,
    /// Wang, Dong, "Constructing iterative non-uniform B-spline curve and surface to fit data points",
    /// 2004).
    fn interpolate(&mut self, anchors: &[Point]) {
        let limit = self.limit_points();
        let points = self.mesh.points.iter_mut().zip(anchors.iter().zip(&limit));
        points.for_each(|(p, (anchor, limit))| *p += anchor - limit);
    }

    /// The control points.
    pub fn control(&self) -> Vec<Vector> {
        self.mesh.points.iter().map(|p| p.coords).collect()
    }
}

/// Fits a surface to a body without gaps. The tolerance holds for its measured vertices.
///
/// # Errors
/// [`Error::Input`] if the quad mesh cannot be used. [`Error::Singular`] if the equations have no
/// solution.
pub fn fit(quads: &QuadMesh, scan: &Patch, options: &Options) -> Result<(Net, Report)> {
    let fit = fit_with(quads, scan, options, &mut progress::ignore)?;
    Ok((fit.net, fit.report))
}

/// The same, telling how far it has come. The fit can go on.
///
/// # Errors
/// Those of [`fit`], and what `progress` returns.
pub fn fit_with<'a>(
    quads: &QuadMesh,
    scan: &'a Patch,
    options: &'a Options,
    progress: &mut Progress,
) -> Result<NetFit<'a>> {
    let mut target = FitTarget::new(scan, options);
    let points = target.weights.iter().filter(|&&weight| weight > FILLED).count();
    let mut quads = quads.clone();
    let mut level = 0;
    loop {
        let fit = NetFit::new(quads, target, level, progress)?;
        let finest = (points / POINTS_OF_CONTROL / fit.net.mesh.blocks()).isqrt();
        let side = finest.min(options.max_side).min(2 * fit.net.mesh.side);
        if fit.report.beyond <= options.outliers || side * COARSER < fit.net.mesh.side * FINER {
            return Ok(fit);
        }
        quads = fit.net.with_side(side);
        target = fit.target;
        level += 1;
    }
}

/// What a surface is fitted to.
struct FitTarget<'a> {
    points: &'a [Point],
    /// The number of measured points. They come first.
    measured: usize,
    normals: Vec<Vector>,
    /// The weight of each point.
    weights: Vec<f64>,
    options: &'a Options,
}

impl<'a> FitTarget<'a> {
    fn new(scan: &'a Patch, options: &'a Options) -> Self {
        let on_measured = scan.on_measured().into_iter();
        let counts = scan.counts();
        let weight = |(point, is_on_measured)| match is_on_measured {
            true if point < scan.measured => counts[point],
            true => BETWEEN,
            false => FILLED,
        };
        FitTarget {
            points: &scan.mesh.points,
            measured: scan.measured.min(scan.mesh.points.len()),
            normals: scan.mesh.vertex_normals(),
            weights: on_measured.enumerate().map(weight).collect(),
            options,
        }
    }
}

/// A fitted net, which can be held more firmly to the layout.
pub struct NetFit<'a> {
    /// The surface.
    pub net: Net,
    /// The results.
    pub report: Report,
    target: FitTarget<'a>,
    /// The places of the layout at the vertices.
    anchors: Vec<Point>,
    /// How firmly each vertex is held to its anchor.
    firmness: Vec<f64>,
    feet: Feet,
    equations: NetEquations,
}

impl<'a> NetFit<'a> {
    /// Fits the control points of one net. The surface is held near the vertices of the quads.
    fn new(
        quads: QuadMesh,
        target: FitTarget<'a>,
        level: i32,
        progress: &mut Progress,
    ) -> Result<Self> {
        // The share of the time that is left after this level, if each takes four times as long.
        let share = |round: usize| 1.0 - 0.8f64.powi(level) * (1.0 - 0.2 * round as f64 / 5.0);
        let anchors = quads.points.clone();
        let mut net = Net::new(quads)?;
        (0..INTERPOLATIONS).for_each(|_| net.interpolate(&anchors));
        let feet = Feet::new(&net, target.points, &target.normals);
        let firmness = vec![1.0; net.mesh.points.len()];
        let equations = NetEquations::new(&net)?;
        let report = Report::default();
        let mut fit = NetFit { net, report, target, anchors, firmness, feet, equations };
        for round in 0..ROUNDS + FIRMER_ROUNDS {
            progress(share(round.min(ROUNDS)))?;
            if round >= ROUNDS && !fit.make_firmer(&inverted::quads(&fit.net)) {
                break;
            }
            fit.move_points(round == 0)?;
        }
        fit.report = Report::of(&fit);
        Ok(fit)
    }

    /// Finds the control points, and the foot points on the new surface. They are searched on the whole
    /// surface if it is the `first` one.
    fn move_points(&mut self, first: bool) -> Result<()> {
        let NetFit { net, target, anchors, firmness, feet, equations, .. } = self;
        net.mesh.points = equations.control_points(net, target, feet, firmness, anchors)?;
        *feet = match first {
            true => Feet::new(net, target.points, &target.normals),
            false => feet.moved(net, target.points, &target.normals),
        };
        Ok(())
    }

    /// Holds the vertices of some quads and their neighbours more firmly. Returns whether there are any.
    fn make_firmer(&mut self, quads: &[usize]) -> bool {
        let mut near = vec![false; self.firmness.len()];
        for &quad in quads {
            self.net.surface.control(quad).iter().for_each(|&v| near[v as usize] = true);
        }
        let firmness = self.firmness.iter_mut().zip(near).filter(|(_, near)| *near);
        firmness.for_each(|(firmness, _)| *firmness *= FIRMER);
        !quads.is_empty()
    }

    /// The points with foot points, block by block. Their places on a block have coordinates from 0 to its side.
    /// The weight of a measured point is the number of points for which it stands, and that of the others is below one.
    pub fn samples(&self) -> Vec<Samples> {
        let mesh = &self.net.mesh;
        let mut samples = vec![Samples::default(); mesh.blocks()];
        for (point, foot) in self.feet.feet.iter().enumerate() {
            if let Some(QuadFoot { place, .. }) = foot {
                let (block, corner) = mesh.place(place.quad);
                let of = &mut samples[block];
                of.points.push(self.target.points[point]);
                of.uv.push(corner + place.at.coords);
                of.weights.push(self.target.weights[point]);
            }
        }
        samples
    }

    /// Fits again, and holds the surface more firmly to the layout near some places, each with the number
    /// of its block.
    ///
    /// # Errors
    /// [`Error::Singular`] if the equations have no solution.
    pub(crate) fn hold(&mut self, places: &[(usize, Point)]) -> Result<()> {
        let per_block = self.net.mesh.side * self.net.mesh.side;
        let off = |quad: usize, p: Point| {
            let corners = self.net.mesh.quads[quad].map(|v| self.anchors[v.index()].coords);
            (corners.iter().sum::<Vector>() / 4.0 - p.coords).norm_squared()
        };
        let nearest = |&(block, p): &(usize, Point)| {
            let quads = per_block * block..per_block * (block + 1);
            quads.min_by(|&a, &b| off(a, p).total_cmp(&off(b, p)))
        };
        let quads: Vec<usize> = places.iter().filter_map(nearest).collect();
        self.make_firmer(&quads);
        self.move_points(false)?;
        self.report = Report::of(self);
        Ok(())
    }
}

impl Report {
    /// The report with all lengths multiplied by a factor.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Report { rms: factor * self.rms, ..self }
    }

    fn of(fit: &NetFit) -> Self {
        let (net, options) = (&fit.net, fit.target.options);
        let all = &fit.feet.feet[..fit.target.measured];
        let distances: Vec<f64> = all.iter().flatten().map(|foot| foot.distance).collect();
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        let beyond = distances.iter().filter(|&&d| d > options.tolerance).count();
        let without_foot = all.len() - distances.len();
        Report {
            control_points: net.mesh.points.len(),
            side: net.mesh.side,
            rms: (squares / distances.len().max(1) as f64).sqrt(),
            beyond: (beyond + without_foot) as f64 / all.len().max(1) as f64,
            inverted: inverted::quads(net).len(),
            without_foot,
        }
    }
}
