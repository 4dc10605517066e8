//! What a conversion makes and finds out: parts, which have bodies, which have faces.

use formats::Brep;
use formats::brep::ShellId;
use formats::scene::Placement;
use rayon::prelude::*;

use super::{InputReport, TargetShape};
use crate::deviation::{Deviation, FaceToScan, TrimmedFace, of_network};
use crate::error::{BrepFault, Error, Result};
use crate::geometry::{Point, Vector};
use crate::mesh::{Mesh, StandIns, Triangles, VertexMap};
use crate::primitives::{Primitive, Uncertainty};
use crate::spline::{Network, NetworkCut, Surface};
use crate::stages::adapt::Adapted;
use crate::stages::regions::Snap;
use crate::stages::seams::{ClosedGap, Fallback};
use crate::stages::sharpen::{Riser, SizeKind};
use crate::stages::{fill, layout, net, parameterize, smooth, thin, trim};
use crate::statistics::SIGNIFICANT;
use crate::words::{grouped, mm, plural};

/// What became of a scan.
#[derive(Debug)]
#[non_exhaustive]
pub struct Conversion {
    /// The parts. A scan has one.
    pub parts: Vec<Part>,
    /// Why the bodies do not have the shape that was tried first.
    pub fallback: Option<String>,
    /// The mean colour of the scan's vertices, if they have one.
    pub colour: Option<[u8; 3]>,
}

/// One part with all its bodies in one B-rep.
#[derive(Debug)]
#[non_exhaustive]
pub struct Part {
    /// What the writers take.
    pub brep: Brep,
    /// A body for each component. A void follows its solid.
    pub bodies: Vec<Body>,
}

/// A component that became one face, a shell, a solid, or a void in the solid before it. Lengths are in mm.
#[derive(Debug)]
#[non_exhaustive]
pub struct Body {
    /// The boundary representation of this body alone.
    pub brep: Brep,
    /// What it is.
    pub shape: TargetShape,
    /// The surfaces, and what their stages found.
    pub fit: BodyFit,
    /// What came in.
    pub input: InputReport,
    /// What smoothing did.
    pub smooth: smooth::Report,
    /// What was filled.
    pub fill: fill::Report,
    /// Which of the fills were cut out again.
    pub trimmed: Vec<bool>,
    /// The tolerance that holds.
    pub tolerance: f64,
    /// Whether the caller named it.
    pub tolerance_named: bool,
    /// The share of points that may miss a tolerance that nobody named.
    pub spared: f64,
    /// Standard deviation of the noise of the measured points along the normal.
    pub noise: f64,
    /// The smoothed points that miss the tolerance.
    pub missed: Missed,
    /// Deviation of the smoothed points; the tolerance is held against it.
    pub fit_deviation: Deviation,
    /// Deviation of the points as they were measured: of the vertices of the scan's mesh, or of
    /// the points of the cloud that the mesh was made of.
    pub deviation: Deviation,
    /// Deviation of the vertices of the mesh, if it was made of a cloud.
    pub(crate) vertex_deviation: Option<Deviation>,
    /// How far the faces are from the smoothed scan's triangles, fills left out.
    pub face_to_scan: FaceToScan,
    /// Where the places of the conversion are measured from in the scan's own frame: zero,
    /// or a point near a cloud that is far from zero.
    pub origin: [f64; 3],
    /// Where [`Builder::align`](super::Builder::align) has put the body: places of the scan's own frame in mm, and where they are now.
    pub placement: Option<Placement>,
    /// What could be better, and what to do about it: a sentence each. Options have the
    /// names that they have on the command line.
    pub hints: Vec<String>,
    /// Which of the smoothed points stands for each vertex of the scan's mesh, if the mesh was thinned before it was smoothed.
    pub(super) stand_ins: Option<StandIns>,
    /// Which point each vertex of the scan became.
    pub(super) vertices: VertexMap,
}

/// How the faces of a body were made.
#[derive(Debug)]
pub enum BodyFit {
    /// One surface.
    Face(Box<SurfaceFit>),
    /// A network of surfaces that share edges.
    Network(Box<NetworkFit>),
    /// The surfaces that a CAD program had.
    Exact(Box<ExactFit>),
}

/// The exact faces of a clean mesh.
#[derive(Debug)]
#[non_exhaustive]
pub struct ExactFit {
    /// Each face, in the order of the B-rep.
    pub faces: Vec<ExactFace>,
    /// The mesh in mm. Triangles that close its gaps are behind its own.
    pub mesh: Mesh,
    /// The length in mm of the unit of `snaps`.
    pub(crate) mm: f64,
    /// For each triangle of the mesh its face.
    pub of_triangle: Vec<u32>,
    /// The number of faces that are only facets.
    pub facets: usize,
    /// The number of free-form faces, which are B-splines where no surface was found.
    pub free_forms: usize,
    /// The faces that were found, but became facets.
    pub fallbacks: Vec<Fallback>,
    /// The gaps of the mesh that were closed.
    pub gaps: Vec<ClosedGap>,
    /// Where the surfaces of a scan do not meet, so that triangles join them.
    pub risers: Vec<Riser>,
    /// What was moved within the rounding of the file.
    pub snaps: Vec<Snap>,
    /// Sizes of a scan that are round within two standard deviations.
    pub round_sizes: Vec<FaceSize>,
    /// The share of the area that is neither facets nor free-form.
    pub explained: f64,
    /// The bound of the errors of the vertices in mm: the rounding of the file, or of the program that computed them. 0 if
    /// the scan is noisy.
    pub rounding: f64,
    /// The factor by which `rounding` is larger than the rounding of the file. 1 for most files.
    pub rounding_factor: f64,
    /// The standard deviation of the noise in mm, if the scan is noisy.
    pub noise: Option<f64>,
}

/// An exact face. Lengths are in mm.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct ExactFace {
    /// The surface.
    pub surface: Primitive,
    /// +1 if the outside of the part is where the distance to the surface is positive, -1 otherwise.
    pub side: f64,
    /// Whether the surface is only the plane of facets, or of a free-form face.
    pub is_facet: bool,
    /// Whether the face is a B-spline in place of facets, of which the surface above is only a plane.
    pub is_free: bool,
    /// The root mean square distance of its vertices from the surface.
    pub rms: f64,
    /// The largest of these distances.
    pub max: f64,
    /// The number of its vertices.
    pub points: usize,
    /// How exactly a scan tells the surface. `None` for clean meshes, and where few vertices tell it.
    pub uncertainty: Option<Uncertainty>,
}

/// A size of faces that is round within two standard deviations. Lengths are in mm, and angles in radians.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FaceSize {
    /// What it is.
    pub kind: SizeKind,
    /// The faces that have it. Of a distance the two planes.
    pub faces: Vec<usize>,
    /// The value that the scan tells.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
    /// The round number.
    pub round: f64,
    /// Whether the faces have it.
    pub is_taken: bool,
}

/// One trimmed surface, and what its stages found.
#[derive(Debug)]
#[non_exhaustive]
pub struct SurfaceFit {
    /// The fitted surface.
    pub surface: Surface,
    /// The loops: the outer one unless it is on the surface's sides, those of the
    /// holes cut out and of the islands in them.
    pub loops: Vec<trim::TrimLoop>,
    /// What was thinned for the smoothing, the map and the fit.
    pub thin: thin::Report,
    /// How good the map is.
    pub parameterize: parameterize::Report,
    /// Where it leaves too little room for the tolerance.
    pub crushed: Option<parameterize::CompressedRegion>,
    /// Knots and fit.
    pub adapted: Adapted,
    /// The outer boundary on the surface's sides: control points of its edges,
    /// and the farthest that a smoothed boundary vertex is from them.
    /// `None`: it is one of the loops.
    pub outer: Option<(usize, f64)>,
    /// How the loops turned out.
    pub trim: Vec<trim::LoopReport>,
    /// How far a loop may be from its rim.
    pub rim_tolerance: f64,
}

/// A network of surfaces, and what its stages found.
#[derive(Debug)]
#[non_exhaustive]
pub struct NetworkFit {
    /// The surfaces and their sides.
    pub network: Network,
    /// The loops along the gaps, and the faces that they leave.
    pub cut: NetworkCut,
    /// What was thinned for the smoothing and the fit.
    pub thin: thin::Report,
    /// The quads.
    pub layout: layout::Report,
    /// The fit of the surface.
    pub net: net::Report,
    /// The number of irregular vertices.
    pub irregular: usize,
    /// The gaps that stay filled although they should be cut out.
    pub left_filled: Vec<LeftFilled>,
    /// The number of places at which faces turn over.
    pub folds: usize,
    /// The angles between neighbouring faces.
    pub seams: Seams,
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

/// A gap of a shell that stays filled, because it cannot be cut out of the faces.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LeftFilled {
    /// The hole, counted from 0 in the report's order.
    pub hole: usize,
    /// What is wrong with its loop.
    pub fault: &'static str,
    /// Where, in mm.
    pub at: [f64; 3],
}

impl LeftFilled {
    pub(super) fn scaled(self, factor: f64) -> Self {
        LeftFilled { at: self.at.map(|x| factor * x), ..self }
    }
}

/// Points so many mm from a triangle are on it: the precision of modelling kernels.
const ON_TRIANGLE: f64 = 1e-7;

impl ExactFit {
    /// The distances of points from the faces. The triangles of the mesh tell which face is near, and where it ends. Beside its
    /// end the triangles tell how far it is.
    fn distances(&self, points: &[Point]) -> Vec<f64> {
        let triangles = Triangles::new(&self.mesh);
        let distance = |&p: &Point| {
            let (off, triangle) = triangles.nearest(p);
            let surface = &self.faces[self.of_triangle[triangle] as usize].surface;
            let foot = surface.closest(p);
            let (beside, there) = triangles.nearest(foot);
            let is_same = self.of_triangle[there] == self.of_triangle[triangle];
            if is_same && beside <= self.chord(there, surface) { (p - foot).norm() } else { off }
        };
        points.par_iter().map(distance).collect()
    }

    /// How far a triangle is from its surface at most.
    fn chord(&self, triangle: usize, surface: &Primitive) -> f64 {
        let [a, b, c] = self.mesh.corners(self.mesh.triangles[triangle]).map(|p| p.coords);
        let places = [(a + b + c) / 3.0, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        let off = |p: &Vector| surface.distance(Point::from(*p)).0.abs();
        places.iter().map(off).fold(self.rounding.max(ON_TRIANGLE), f64::max)
    }
}

impl Conversion {
    /// Where [`Builder::align`](super::Builder::align) has put the parts: places of the scan's own frame in mm, and where they are now.
    pub fn placement(&self) -> Option<Placement> {
        self.bodies().find_map(|body| body.placement)
    }

    /// The only body, if there is one.
    pub fn into_body(mut self) -> Option<Body> {
        let bodies = &mut self.parts.pop()?.bodies;
        bodies.pop().filter(|_| bodies.is_empty() && self.parts.is_empty())
    }

    /// The bodies of all parts.
    pub fn bodies(&self) -> impl Iterator<Item = &Body> {
        self.parts.iter().flat_map(|part| &part.bodies)
    }
}

impl Part {
    /// A part of these bodies. A void becomes one of the last solid before it.
    pub(super) fn of(name: &str, bodies: Vec<Body>) -> Result<Part> {
        let description =
            bodies.first().map_or(String::new(), |body| body.brep.description.clone());
        let mut brep = Brep { name: name.into(), description, ..Brep::default() };
        for body in &bodies {
            brep.append(body.brep.clone());
            if let (TargetShape::Void, Some(last)) = (body.shape, brep.solids.last_mut()) {
                last.voids.push(ShellId(brep.shells.len() - 1));
            }
        }
        if bodies.iter().any(|body| body.shape != TargetShape::Face) {
            brep.check().map_err(|fault| Error::Brep(BrepFault::Parts(fault)))?;
        }
        Ok(Part { brep, bodies })
    }
}

impl Body {
    /// A place of the body in the scan's own frame, in mm.
    pub(super) fn in_scan(&self, at: Point) -> Point {
        let Some(Placement { axes, translation }) = self.placement else {
            return at + Vector::from(self.origin);
        };
        // The inverse of a turn is its transpose.
        let off = at.coords - Vector::from(translation);
        Point::from(axes.map(|axis| Vector::from(axis).dot(&off)))
    }

    /// The surface and its figures, if the body is one face.
    pub fn face(&self) -> Option<&SurfaceFit> {
        match &self.fit {
            BodyFit::Face(face) => Some(face),
            BodyFit::Network(_) | BodyFit::Exact(_) => None,
        }
    }

    /// What was averaged and thinned before the smoothing. `None` if its faces are exact.
    pub fn thin(&self) -> Option<thin::Report> {
        match &self.fit {
            BodyFit::Face(fit) => Some(fit.thin),
            BodyFit::Network(fit) => Some(fit.thin),
            BodyFit::Exact(_) => None,
        }
    }

    /// The surfaces and their figures, if the body has several faces.
    pub fn network(&self) -> Option<&NetworkFit> {
        match &self.fit {
            BodyFit::Network(network) => Some(network),
            BodyFit::Face(_) | BodyFit::Exact(_) => None,
        }
    }

    /// The exact faces and their figures, if the scan is a clean mesh.
    pub fn exact(&self) -> Option<&ExactFit> {
        match &self.fit {
            BodyFit::Exact(exact) => Some(exact),
            BodyFit::Face(_) | BodyFit::Network(_) => None,
        }
    }

    /// The B-spline surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        match &self.fit {
            BodyFit::Face(face) => std::slice::from_ref(&face.surface),
            BodyFit::Network(fit) => &fit.network.surfaces,
            BodyFit::Exact(_) => &[],
        }
    }

    /// The enclosed volume of a solid in mm³. That of a void is negative.
    pub fn volume(&self) -> Option<f64> {
        let volume = || (0..self.brep.shells.len()).map(|s| self.brep.volume(ShellId(s))).sum();
        matches!(self.shape, TargetShape::Solid | TargetShape::Void).then(volume)
    }

    /// The distances of points from the faces.
    pub fn distances(&self, points: &[Point]) -> Vec<f64> {
        match &self.fit {
            BodyFit::Network(fit) => of_network(&fit.network, &fit.cut, points).distances,
            BodyFit::Exact(fit) => fit.distances(points),
            BodyFit::Face(fit) => {
                let loops = fit.loops.iter().map(|ring| ring.pcurves.as_slice());
                let face = TrimmedFace::new(&fit.surface, loops, fit.outer.is_some());
                points.iter().map(|&p| face.nearest(p, None).1).collect()
            }
        }
    }

    /// For each vertex of the scan's mesh the distance of the smoothed point that stands for it, positive above the faces.
    pub fn smoothed_distances(&self) -> Vec<f64> {
        let distances = self.fit_deviation.signed().unwrap_or_default();
        match &self.stand_ins {
            Some(stand_ins) => stand_ins.of_scan(&distances),
            None => distances,
        }
    }

    /// Deviation of the vertices of the scan's mesh before smoothing, in the order of
    /// [`smoothed_distances`](Self::smoothed_distances). It is [`deviation`](Self::deviation) unless the mesh
    /// was made of a cloud.
    pub fn vertex_deviation(&self) -> &Deviation {
        self.vertex_deviation.as_ref().unwrap_or(&self.deviation)
    }

    /// The point that a vertex of the scan became: its position among the distances of
    /// [`deviation`](Self::deviation), and of [`smoothed_distances`](Self::smoothed_distances) unless the
    /// scan is a cloud. The vertices of a cloud are its points.
    /// Vertices are counted from 0, in the order of the soup or of the file. All at one place
    /// became one point. `None` if the vertex was left out: no triangle has it, it is not
    /// finite, or it belongs to another component or to a triangle that was dropped.
    pub fn point_of(&self, vertex: usize) -> Option<usize> {
        self.vertices.point_of(vertex)
    }

    /// Whether the faces keep their tolerance. Where it is named, all but the share `outliers`
    /// of the smoothed points must be within it, and as many of the places that were compared with the
    /// scan's triangles, which the faces may leave by their chord error besides, and every gap must be cut out. Where
    /// nobody named one, all but as many points as normal noise has beyond three standard deviations.
    pub fn tolerance_met(&self, outliers: f64) -> bool {
        let outliers = if self.tolerance_named { outliers } else { outliers.max(self.spared) };
        let keeps = |beyond: usize, all: usize| beyond as f64 <= outliers * all as f64;
        let back = &self.face_to_scan;
        keeps(self.missed.points, self.fit_deviation.distances.len())
            && (!self.tolerance_named
                || keeps(back.beyond, back.places) && self.left_filled().is_empty())
    }

    /// The gaps of a shell that could not be cut out.
    pub fn left_filled(&self) -> &[LeftFilled] {
        self.network().map(|fit| fit.left_filled.as_slice()).unwrap_or_default()
    }

    /// The number of smoothed points that keep the tolerance although they are farther from the face: a
    /// trim loop, which smooths the rim, cuts them off ([`Missed`]).
    pub fn cut_off(&self) -> usize {
        self.fit_deviation.beyond(self.tolerance).saturating_sub(self.missed.points)
    }

    /// The number of measured points that are farther from the faces than the tolerance and the noise together, if
    /// several points have one mean, and these are more than chance leaves. They are outliers, or the means have lost
    /// what they show.
    pub fn lost_by_means(&self) -> Option<usize> {
        let points = self.deviation.distances.len();
        let are_means = self.thin().is_some_and(|thin| thin.averaged.is_some());
        if !are_means && points <= self.input.vertices || self.tolerance_named {
            return None;
        }
        let lost = self.deviation.beyond(self.tolerance + SIGNIFICANT * self.noise);
        (lost as f64 > self.spared * points as f64).then_some(lost)
    }

    /// How many points, and how much of the faces, are beyond the tolerance, and the worst.
    pub fn beyond(&self) -> String {
        let shape = self.shape.word();
        let mut parts = Vec::new();
        let missed = &self.missed;
        if missed.points > 0 {
            let of = plural(self.fit_deviation.distances.len(), "point");
            let worst = worst(missed.worst, missed.worst_at);
            parts.push(self.farther(missed.points, &of, &format!("the {shape}")) + &worst);
        }
        let back = &self.face_to_scan;
        if self.tolerance_named && back.beyond > 0 {
            let worst = worst(back.max, back.max_at);
            let places = back.places;
            parts.push(match self.shape {
                TargetShape::Face => format!(
                    "the face is farther than {} and their chord error from {} of {}{worst}",
                    mm(self.tolerance),
                    grouped(back.beyond),
                    plural(places, "triangle"),
                ),
                _ => {
                    let of = format!("{} on the {shape}", plural(places, "place"));
                    let from = "the scan's triangles and their chord error";
                    self.farther(back.beyond, &of, from) + &worst
                }
            });
        }
        if !self.left_filled().is_empty() {
            parts
                .push(format!("{} could not be cut out", plural(self.left_filled().len(), "hole")));
        }
        parts.join(", and ")
    }

    /// Says how many of some places are too far from something.
    fn farther(&self, beyond: usize, of: &str, from: &str) -> String {
        let tolerance = mm(self.tolerance);
        format!("{} of {of} are farther than {tolerance} from {from}", grouped(beyond))
    }
}

/// Says how far the farthest of some places is, and where.
fn worst(distance: f64, [x, y, z]: [f64; 3]) -> String {
    format!("; the worst, {}, at ({x:.3}, {y:.3}, {z:.3})", mm(distance))
}

/// A B-rep that is measured from `origin`, moved into the scan's own frame if `keeps_origin`, and else with
/// a note that says where its own frame lies.
pub(super) fn placed(brep: Brep, origin: [f64; 3], keeps_origin: bool) -> Brep {
    let [x, y, z] = origin;
    match keeps_origin {
        _ if origin == [0.0; 3] => brep,
        true => brep.translated(origin),
        false => {
            let description = format!("Coordinates are measured from ({x}, {y}, {z}) mm.");
            Brep { description, ..brep }
        }
    }
}

/// The smoothed points that miss the tolerance. A point that a trim loop cuts off is none of
/// them if it is no farther from the loop than a rim is known, and within the tolerance of
/// the surface.
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct Missed {
    /// How many.
    pub points: usize,
    /// The distance of the farthest, in mm.
    pub worst: f64,
    /// Where it is.
    pub worst_at: [f64; 3],
}

impl Missed {
    /// All points beyond a tolerance.
    pub(super) fn beyond(deviation: &Deviation, tolerance: f64) -> Self {
        let points = deviation.beyond(tolerance);
        Missed { points, worst: deviation.max, worst_at: deviation.max_at }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        let worst_at = self.worst_at.map(|x| factor * x);
        Missed { worst: factor * self.worst, worst_at, ..self }
    }
}

#[cfg(test)]
mod tests {
    use formats::Soup;

    use super::*;
    use crate::convert::{Options, SurfaceChoice, convert};

    /// An open pipe, 20 mm wide and 30 mm long.
    fn pipe() -> Soup {
        let (around, along) = (40u32, 30);
        let mut soup = Soup::default();
        for k in 0..=along {
            for i in 0..around {
                let angle = std::f64::consts::TAU * f64::from(i) / f64::from(around);
                soup.points.push([10.0 * angle.cos(), 10.0 * angle.sin(), f64::from(k)]);
            }
        }
        for k in 0..along {
            for i in 0..around {
                let at = |i: u32, k: u32| k * around + i % around;
                let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
                soup.polygons.push([a, b, c]);
                soup.polygons.push([a, c, d]);
            }
        }
        soup
    }

    #[test]
    fn a_named_tolerance_is_missed_where_a_gap_is_not_cut_out() {
        let spline = Options::builder().surfaces(SurfaceChoice::Spline);
        for (tolerance, named) in [(Some(0.5), true), (None, false)] {
            let options = spline.clone().tolerance(tolerance).build().unwrap();
            let made = convert(&pipe(), &options, &mut |_| Ok(())).unwrap();
            let mut body = made.parts.into_iter().next().unwrap().bodies.remove(0);
            let before = body.tolerance_met(0.0);
            assert!(before || !named, "{}", body.beyond());
            let BodyFit::Network(fit) = &mut body.fit else { panic!("no shell") };
            fit.left_filled.push(LeftFilled { hole: 1, fault: "crosses itself", at: [0.0; 3] });
            assert_eq!(body.tolerance_met(0.0), before && !named);
            assert!(body.beyond().contains("1 hole could not be cut out"));
        }
    }
}
