//! What a fit starts from, as a value.

use std::borrow::Cow;

use super::inner::InnerSamples;
use super::moves::correct::LEAST_AREA;
use super::moves::reject;
use super::problem::Problem;
use crate::geometry::Uv;
use crate::spline::{KnotVector, Samples};
use crate::stages::fit::TangentDistance;

/// The weight of an outlier, as a multiple: none that a fit would show. Equations need it to be
/// above 0.
const OUTLIER_WEIGHT: f64 = 1e-6;

/// Everything that a fit depends on and that a move may change. Moves do not change a state;
/// they return another one.
#[derive(Clone)]
pub(crate) struct State {
    /// The knots along u and v.
    pub knots: [KnotVector; 2],
    /// The parameters of the vertices.
    pub uv: Vec<Uv>,
    /// The weights that the vertices have if they are no outliers.
    pub weights: Vec<f64>,
    /// The numbers of the vertices that count next to nothing.
    pub outliers: Vec<usize>,
    /// Samples inside triangles that hold the surface, too.
    pub inner: InnerSamples,
}

impl State {
    /// The map as it is, over a single knot cell.
    pub(super) fn new(problem: &Problem) -> Self {
        State {
            knots: [(); 2].map(|()| KnotVector::uniform(3, 4)),
            uv: problem.map.uv.clone(),
            weights: problem.weights(),
            outliers: reject::outliers_before_a_fit(problem),
            inner: InnerSamples::default(),
        }
    }

    /// The vertices and, after them, the inner samples, as a fit takes them.
    pub(crate) fn samples(&self, problem: &Problem) -> Samples {
        let mut samples = self.vertices(problem);
        samples.points.extend(self.inner.all.iter().map(|sample| sample.point));
        samples.uv = self.inner.after(samples.uv);
        samples.weights.extend(self.inner.all.iter().map(|sample| sample.weight));
        samples
    }

    /// The vertices alone.
    pub(crate) fn vertices(&self, problem: &Problem) -> Samples {
        let mut weights = self.weights.clone();
        self.outliers.iter().for_each(|&v| weights[v] *= OUTLIER_WEIGHT);
        let points = problem.map.patch.mesh.points.clone();
        Samples { points, uv: self.uv.clone(), weights, open: problem.is_open() }
    }

    /// Where the samples may move to while a surface moves, given where they are `now` and where
    /// they are `wanted`: inner samples go where their vertices do.
    pub(crate) fn slid(&self, problem: &Problem, mut now: Vec<Uv>, mut wanted: Vec<Uv>) -> Vec<Uv> {
        now.truncate(self.uv.len());
        wanted.truncate(self.uv.len());
        self.inner.after(problem.corrected(now, wanted, LEAST_AREA))
    }

    /// How the vertices and, after them, the inner samples hold a surface that slides along them.
    pub(crate) fn holds<'a>(&self, problem: &'a Problem) -> Cow<'a, [TangentDistance]> {
        if self.inner.all.is_empty() {
            return Cow::Borrowed(&problem.holds);
        }
        let inner = self.inner.all.iter().map(|sample| sample.hold);
        Cow::Owned(problem.holds.iter().copied().chain(inner).collect())
    }
}
