//! A vertex with three rings of neighbours, and what a quadric through them leaves.
//!
//! The residuals of a fit are a linear mixture of the errors of the points: with the orthonormal
//! basis Q of the polynomials, e = (I − Q Qᵀ) z. Errors that are correlated between neighbours have
//! covariances c₀, c₁ and c₂ of points that are 0, 1 and 2 edges apart. The expected products of
//! residuals at these distances are then a linear function of the three: mₖ = Σₗ Aₖₗ cₗ with
//! Aₖₗ = tr(Dₖ M Dₗ M), where M = I − Q Qᵀ and Dₖ marks the pairs that are k edges apart.

use nalgebra::{Matrix3, SVector, Vector3};

use crate::geometry::{ROUNDING, Vector, VertexId, plane_axes};
use crate::mesh::{Mesh, VertexRings};

/// The rings of a patch. Two have too few points for the covariances to be told apart.
const RINGS: usize = 3;

/// The coefficients of a quadric.
const QUADRIC: usize = 6;

/// The coefficients of a polynomial of the fourth degree.
const QUARTIC: usize = 15;

/// The coefficients of polynomials of the second, the third and the fourth degree.
const COEFFICIENTS: [usize; DEGREES] = [QUADRIC, 10, QUARTIC];

/// The number of degrees that are fitted.
pub(super) const DEGREES: usize = 3;

/// The vertices of a patch of an even mesh, all of which have six neighbours.
pub(super) const EVEN: usize = 37;

/// The most vertices of a patch. It bounds the time where many triangles meet at one vertex.
const MOST_VERTICES: usize = 4 * EVEN;

/// What the fits of a patch say about the noise.
#[derive(Debug, Clone)]
pub(super) struct NoisePatch {
    /// The vertex in its middle.
    pub middle: VertexId,
    /// The mean number of neighbours that a vertex has within the patch.
    pub neighbours: f64,
    /// The matrix A of the quadric.
    pub mixing: Matrix3<f64>,
    /// The sums of products of the quadric's residuals over pairs that are 0, 1 and 2 edges apart.
    pub moments: Vector3<f64>,
    /// The residuals of polynomials of the second, the third and the fourth degree.
    pub fits: [Residuals; DEGREES],
}

/// What a fit leaves.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Residuals {
    /// The sum of the squares of the residuals, and of their products over edges in both directions.
    pub sums: [f64; 2],
    /// The expectations of both for independent errors of variance 1. The first one is the number of
    /// degrees of freedom.
    pub expected: [f64; 2],
}

impl Residuals {
    /// The variance of independent errors that leave such residuals.
    pub(crate) fn mean_square(&self) -> f64 {
        self.sums[0] / self.expected[0]
    }
}

/// Working memory for the patches of one mesh.
#[derive(Default)]
pub(super) struct Scratch {
    /// For each vertex its position in the patch plus `offset`. Older entries are smaller.
    place: Vec<u32>,
    offset: u32,
    /// The vertices of the patch, in the order of their rings.
    vertices: Vec<VertexId>,
}

impl Scratch {
    /// Finds the vertices within [`RINGS`] edges of a vertex. `false` if they are too many.
    fn gather(&mut self, mesh: &Mesh, rings: &VertexRings, v: VertexId) -> bool {
        self.offset += self.vertices.len() as u32;
        self.place.resize(mesh.points.len(), 0);
        self.vertices.clear();
        self.push(v);
        let mut from = 0;
        for _ in 0..RINGS {
            let to = self.vertices.len();
            for i in from..to {
                for w in rings.neighbours(mesh, self.vertices[i]) {
                    if self.position(w).is_none() {
                        self.push(w);
                    }
                }
                if self.vertices.len() > MOST_VERTICES {
                    return false;
                }
            }
            from = to;
        }
        true
    }

    /// Gathers the patch around a vertex: its vertices as seen from the middle one, and their mean
    /// normal. `None` if they are too few for a polynomial of the fourth degree, or too many.
    fn offsets(
        &mut self,
        mesh: &Mesh,
        rings: &VertexRings,
        normals: &[Vector],
        middle: VertexId,
    ) -> Option<(Vec<Vector>, Vector)> {
        if !self.gather(mesh, rings, middle) || self.vertices.len() <= QUARTIC {
            return None;
        }
        let sum: Vector = self.vertices.iter().map(|v| normals[v.index()]).sum();
        let offsets = self.vertices.iter().map(|&v| mesh.point(v) - mesh.point(middle));
        Some((offsets.collect(), sum.try_normalize(0.0)?))
    }

    fn push(&mut self, v: VertexId) {
        self.vertices.push(v);
        self.place[v.index()] = self.offset + self.vertices.len() as u32;
    }

    /// The position of a vertex in the patch.
    fn position(&self, v: VertexId) -> Option<usize> {
        self.place[v.index()].checked_sub(self.offset + 1).map(|i| i as usize)
    }
}

impl NoisePatch {
    /// Fits the patch around a vertex. `None` if it has too few vertices or too many.
    pub(super) fn new(
        mesh: &Mesh,
        rings: &VertexRings,
        normals: &[Vector],
        middle: VertexId,
        scratch: &mut Scratch,
    ) -> Option<Self> {
        let (offsets, normal) = scratch.offsets(mesh, rings, normals, middle)?;
        let basis = basis(&offsets, normal);
        let pairs = scratch.pairs(mesh, rings);
        let mut residuals: Vec<f64> = offsets.iter().map(|d| d.dot(&normal)).collect();
        let mut fits = [Residuals::default(); DEGREES];
        let mut moments = Vector3::zeros();
        let mut fitted = 0;
        for (fit, count) in fits.iter_mut().zip(COEFFICIENTS) {
            residuals = without(&residuals, &basis, fitted..count);
            let sum = |k: usize| pairs[k].iter().map(|&(i, j)| residuals[i] * residuals[j]).sum();
            if fitted == 0 {
                moments = Vector3::from_fn(|k, _| sum(k));
            }
            let of = |(i, j): (usize, usize)| basis[i].rows(0, count).dot(&basis[j].rows(0, count));
            let mixed = |k: usize| pairs[k].iter().map(|&pair| of(pair)).sum::<f64>();
            *fit = Residuals {
                sums: [0, 1].map(sum),
                expected: [offsets.len() as f64 - mixed(0), -mixed(1)],
            };
            fitted = count;
        }
        let neighbours = pairs[1].len() as f64 / offsets.len() as f64;
        let mixing = mixing(&basis, &pairs);
        let patch = NoisePatch { middle, neighbours, mixing, moments, fits };
        // Vertices at one place have no basis.
        patch.mixing.iter().all(|x| x.is_finite()).then_some(patch)
    }
}

/// PatchPairs of positions in a patch, in both orders.
type PatchPairs = Vec<(usize, usize)>;

impl Scratch {
    /// The pairs of vertices that are 0, 1 and 2 edges apart within the patch.
    fn pairs(&self, mesh: &Mesh, rings: &VertexRings) -> [PatchPairs; 3] {
        let beside = |&v: &VertexId| -> Vec<usize> {
            rings.neighbours(mesh, v).filter_map(|w| self.position(w)).collect()
        };
        let beside: Vec<Vec<usize>> = self.vertices.iter().map(beside).collect();
        let mut pairs = [Vec::new(), Vec::new(), Vec::new()];
        let mut seen = vec![usize::MAX; beside.len()];
        for i in 0..beside.len() {
            let mut add = |j: usize, apart: usize| {
                if seen[j] != i {
                    seen[j] = i;
                    pairs[apart].push((i, j));
                }
            };
            add(i, 0);
            beside[i].iter().for_each(|&j| add(j, 1));
            beside[i].iter().flat_map(|&j| &beside[j]).for_each(|&k| add(k, 2));
        }
        pairs
    }
}

/// A row of the orthonormal basis: the values of its functions at one vertex.
type BasisRow = SVector<f64, QUARTIC>;

/// An orthonormal basis of the polynomials up to the fourth degree over the plane across the
/// normal, by the Gram–Schmidt process. The first [`QUADRIC`] functions span the quadrics. A
/// function that depends on those before it is zero.
fn basis(offsets: &[Vector], normal: Vector) -> Vec<BasisRow> {
    let (x, y) = plane_axes(normal);
    let extent = offsets.iter().map(|d| d.norm_squared()).fold(0.0, f64::max).sqrt();
    let mut rows: Vec<BasisRow> =
        offsets.iter().map(|d| monomials(d.dot(&x) / extent, d.dot(&y) / extent)).collect();
    for k in 0..QUARTIC {
        let length = |rows: &[BasisRow]| rows.iter().map(|row| row[k] * row[k]).sum::<f64>().sqrt();
        let before = length(&rows);
        // Once more takes out the rounding errors of the first time.
        for j in (0..k).chain(0..k) {
            let shared: f64 = rows.iter().map(|row| row[k] * row[j]).sum();
            rows.iter_mut().for_each(|row| row[k] -= shared * row[j]);
        }
        let left = length(&rows);
        // What is left may be a rounding error: vertices may lie on a line, for example.
        let scale = if left > ROUNDING.sqrt() * before { 1.0 / left } else { 0.0 };
        rows.iter_mut().for_each(|row| row[k] *= scale);
    }
    rows
}

fn monomials(x: f64, y: f64) -> BasisRow {
    let (xx, xy, yy) = (x * x, x * y, y * y);
    let linear = [1.0, x, y];
    let quadratic = [xx, xy, yy];
    let cubic = [x * xx, x * xy, y * xy, y * yy];
    let quartic = [xx * xx, xx * xy, xx * yy, xy * yy, yy * yy];
    BasisRow::from_iterator(linear.into_iter().chain(quadratic).chain(cubic).chain(quartic))
}

/// The values without their components along some functions of the basis.
fn without(values: &[f64], basis: &[BasisRow], functions: std::ops::Range<usize>) -> Vec<f64> {
    let mut left = values.to_vec();
    for k in functions {
        let along: f64 = left.iter().zip(basis).map(|(z, row)| z * row[k]).sum();
        left.iter_mut().zip(basis).for_each(|(z, row)| *z -= along * row[k]);
    }
    left
}

/// The matrix A for the quadrics: δₖₗ tr Dₖ² − 2 ⟨Dₖ Q, Dₗ Q⟩ + ⟨Qᵀ Dₖ Q, Qᵀ Dₗ Q⟩.
fn mixing(basis: &[BasisRow], pairs: &[PatchPairs; 3]) -> Matrix3<f64> {
    let first: Vec<SVector<f64, QUADRIC>> =
        basis.iter().map(|row| row.fixed_rows::<QUADRIC>(0).into_owned()).collect();
    let product = |pairs: &PatchPairs| {
        let mut product = vec![SVector::<f64, QUADRIC>::zeros(); first.len()];
        pairs.iter().for_each(|&(i, j)| product[i] += first[j]);
        product
    };
    let outer = |product: &Vec<SVector<f64, QUADRIC>>| -> nalgebra::SMatrix<f64, QUADRIC, QUADRIC> {
        first.iter().zip(product).map(|(q, p)| q * p.transpose()).sum()
    };
    let products = pairs.each_ref().map(product);
    let inner = products.each_ref().map(outer);
    let shared = |k: usize, l: usize| -> f64 {
        products[k].iter().zip(&products[l]).map(|(a, b)| a.dot(b)).sum()
    };
    Matrix3::from_fn(|k, l| {
        let own = if k == l { pairs[k].len() as f64 } else { 0.0 };
        own - 2.0 * shared(k, l) + inner[k].dot(&inner[l])
    })
}

/// The heights of a patch over the quadric through all of its vertices but the middle one.
pub(super) struct Heights {
    /// The height of the middle vertex.
    pub middle: f64,
    /// Its variance if that of the points is 1.
    pub variance: f64,
    /// The heights of the others.
    pub others: Vec<f64>,
    /// How many of these are neighbours of the middle vertex; they come first.
    pub neighbours: usize,
}

impl Heights {
    /// Fits the patch around a vertex without the vertex itself.
    pub(crate) fn without_middle(
        mesh: &Mesh,
        rings: &VertexRings,
        normals: &[Vector],
        middle: VertexId,
        scratch: &mut Scratch,
    ) -> Option<Self> {
        let (offsets, normal) = scratch.offsets(mesh, rings, normals, middle)?;
        let neighbours = rings.neighbours(mesh, middle).count();
        let basis = basis(&offsets, normal);
        let heights: Vec<f64> = offsets.iter().map(|d| d.dot(&normal)).collect();
        let residuals = without(&heights, &basis, 0..QUADRIC);
        // Without a point, its residual is larger by 1 / (1 − leverage), and the fit changes by as
        // much of its influence.
        let first = |i: usize| basis[i].fixed_rows::<QUADRIC>(0);
        let free = 1.0 - first(0).norm_squared();
        if free <= ROUNDING.sqrt() {
            return None;
        }
        let height = residuals[0] / free;
        let other = |i: usize| residuals[i] + height * first(i).dot(&first(0));
        Some(Heights {
            middle: height,
            variance: 1.0 / free,
            others: (1..residuals.len()).map(other).collect(),
            neighbours,
        })
    }
}
