//! What a conversion makes and finds out.

use formats::Brep;

use crate::convert::InputReport;
use crate::deviation;
use crate::mesh::VertexMap;
use crate::spline::Surface;
use crate::stages::adapt::Adapted;
use crate::stages::{fill, parameterize, smooth, thin, trim};
use crate::words::{grouped, mm, plural};

/// A converted scan.
#[derive(Debug)]
#[non_exhaustive]
pub struct Conversion {
    /// What the writers take.
    pub brep: Brep,
    /// The fitted surface.
    pub surface: Surface,
    /// The loops: the outer one unless it is on the surface's sides, those of the
    /// holes cut out and of the islands in them.
    pub loops: Vec<trim::TrimLoop>,
    /// What came in.
    pub input: InputReport,
    /// What smoothing did.
    pub smooth: smooth::Report,
    /// What was filled.
    pub fill: fill::Report,
    /// Which of the filled holes were cut out.
    pub trimmed: Vec<bool>,
    /// What was thinned for the map and the fit.
    pub thin: thin::Report,
    /// How good the map is.
    pub parameterize: parameterize::Report,
    /// Where it leaves too little room for the tolerance.
    pub crushed: Option<parameterize::CompressedRegion>,
    /// Knots and fit.
    pub fit: Adapted,
    /// The tolerance that holds, in mm.
    pub tolerance: f64,
    /// Whether the user named it.
    pub tolerance_named: bool,
    /// The share of points that may miss a tolerance that nobody named.
    pub spared: f64,
    /// The points that miss it.
    pub missed: Missed,
    /// How far the face is from the smoothed scan's triangles, fills left out.
    pub face_to_scan: deviation::FaceToScan,
    /// Deviation of the smoothed points from the trimmed face; the tolerance
    /// is held against it.
    pub fit_deviation: deviation::Deviation,
    /// Deviation of the points as they were measured: of the vertices of the scan's mesh, or of
    /// the points of the cloud that the mesh was made of.
    pub deviation: deviation::Deviation,
    /// Deviation of the vertices of the mesh, if it was made of a cloud.
    pub(crate) vertex_deviation: Option<deviation::Deviation>,
    /// Standard deviation of the noise of the measured points along the normal, in mm.
    pub noise: f64,
    /// Where the places of the conversion are measured from in the scan's own frame, in mm: zero,
    /// or a point near a cloud that is far from zero.
    pub origin: [f64; 3],
    /// The outer boundary on the surface's sides: control points of its edges,
    /// and the farthest, in mm, that a smoothed boundary vertex is from them.
    /// `None`: it is one of the loops.
    pub outer: Option<(usize, f64)>,
    /// How the loops turned out.
    pub trim: Vec<trim::LoopReport>,
    /// How far a loop may be from its rim, in mm.
    pub rim_tolerance: f64,
    /// What could be better, and what to do about it: a sentence each. Options have the
    /// names that they have on the command line.
    pub hints: Vec<String>,
    /// Which point each vertex of the scan became.
    pub(super) vertices: VertexMap,
}

impl Conversion {
    /// Deviation of the vertices of the scan's mesh before smoothing, in the order of
    /// [`fit_deviation`](Self::fit_deviation). It is [`deviation`](Self::deviation) unless the mesh
    /// was made of a cloud.
    pub fn vertex_deviation(&self) -> &deviation::Deviation {
        self.vertex_deviation.as_ref().unwrap_or(&self.deviation)
    }

    /// The point that a vertex of the scan became: its position among the distances of
    /// [`deviation`](Self::deviation), and of [`fit_deviation`](Self::fit_deviation) unless the
    /// scan is a cloud. The vertices of a cloud are its points.
    /// Vertices are counted from 0, in the order of the soup or of the file. All at one place
    /// became one point. `None` if the vertex was left out: no triangle has it, it is not
    /// finite, or it belongs to another component or to a triangle that was dropped.
    pub fn point_of(&self, vertex: usize) -> Option<usize> {
        self.vertices.point_of(vertex)
    }

    /// Whether the face keeps its tolerance. Where it is named, all but the share `outliers`
    /// of the smoothed points must be within it, and as many of the triangles, which the face
    /// may leave by their chord error besides. Where nobody named one, all but as many points
    /// as normal noise has beyond three standard deviations.
    pub fn tolerance_met(&self, outliers: f64) -> bool {
        let outliers = if self.tolerance_named { outliers } else { outliers.max(self.spared) };
        let keeps = |beyond: usize, all: usize| beyond as f64 <= outliers * all as f64;
        let back = &self.face_to_scan;
        keeps(self.missed.points, self.fit_deviation.distances.len())
            && (!self.tolerance_named || keeps(back.beyond, back.triangles))
    }

    /// The number of smoothed points that keep the tolerance although they are farther from the face: a
    /// trim loop, which smooths the rim, cuts them off ([`Missed`]).
    pub fn cut_off(&self) -> usize {
        self.fit_deviation.beyond(self.tolerance).saturating_sub(self.missed.points)
    }

    /// How many points, and how much of the face, are beyond the tolerance, and the worst.
    pub fn beyond(&self) -> String {
        let mut parts = Vec::new();
        let missed = &self.missed;
        if missed.points > 0 {
            let of = plural(self.fit_deviation.distances.len(), "point");
            let worst = worst(missed.worst, missed.worst_at);
            parts.push(farther(missed.points, &of, self.tolerance, "the face") + &worst);
        }
        let back = &self.face_to_scan;
        if self.tolerance_named && back.beyond > 0 {
            parts.push(format!(
                "the face is farther than {} and their chord error from {} of {}{}",
                mm(self.tolerance),
                grouped(back.beyond),
                plural(back.triangles, "triangle"),
                worst(back.max, back.max_at),
            ));
        }
        parts.join(", and ")
    }
}

/// Says how many of some places are too far from something.
pub(super) fn farther(beyond: usize, of: &str, tolerance: f64, from: &str) -> String {
    format!("{} of {of} are farther than {} from {from}", grouped(beyond), mm(tolerance))
}

/// Says how far the farthest of these places is, and where.
pub(super) fn worst(distance: f64, [x, y, z]: [f64; 3]) -> String {
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
    pub(super) fn scaled(self, factor: f64) -> Self {
        let worst_at = self.worst_at.map(|x| factor * x);
        Missed { worst: factor * self.worst, worst_at, ..self }
    }
}
