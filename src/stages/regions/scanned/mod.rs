//! The faces of a part, found again in a noisy scan of it.
//!
//! No vertex lies on an edge, and every vertex is off its true surface by the noise. So all decisions are those of
//! statistics with a known standard deviation: a surface is accepted if the noise explains its residuals, kinds are
//! chosen by the Bayesian information criterion, and borders lie where they are likeliest.
//!
//! - [`scan`] filters the normals and finds creases; [`starts`] and [`model`] fit and judge surfaces.
//! - [`seeds`] and [`growth`] find regions, [`division`] merges them, absorbs them, and moves their borders.
//! - [`freeform`] gives up regions that are pieces of a free-form surface.
//! - [`result`] makes regions of triangles.
//!
//! The method is region growing with orthogonal fits (Várady, Martin, Cox, "Reverse engineering of geometric models",
//! 1997; Benkő, Várady, "Segmentation methods for smooth point regions of conventional engineering objects", 2004).

mod blends;
mod division;
mod freeform;
mod growth;
mod model;
mod result;
mod scan;
mod seeds;
mod starts;
#[cfg(test)]
mod tests;

use super::Regions;
use crate::geometry::VertexId;
use crate::mesh::{EdgeMap, Mesh, VertexRings};
use crate::noise::NoiseField;
use division::Division;
use growth::Room;
use scan::NoisyScan;

/// The noise of a scan as the search for regions needs it.
#[derive(Debug, Clone)]
pub struct ScanNoise {
    /// The standard deviation along the normal over the whole scan, in the unit of the mesh.
    pub deviation: f64,
    /// The correlations of vertices that are one edge and two edges apart.
    pub correlation: [f64; 2],
    /// Whether there is noise beyond the rounding of the file.
    pub is_visible: bool,
    /// Systematic errors of the scanner, which neighbouring vertices share, in the unit of the mesh.
    pub bias: f64,
    at: Vec<f64>,
}

/// Correlations below this are those of chance.
const LEAST_CORRELATION: f64 = 0.08;

impl ScanNoise {
    /// Measures the noise of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        Self::from_field(&NoiseField::new(mesh, &VertexRings::new(mesh)), mesh)
    }

    /// The noise that was measured.
    pub(crate) fn from_field(field: &NoiseField, mesh: &Mesh) -> Self {
        let [one, two] = field.correlation;
        let is_independent = one < LEAST_CORRELATION;
        let correlation =
            if is_independent { [0.0; 2] } else { [one, two].map(|c| c.clamp(0.0, 1.0)) };
        let at = (0..mesh.points.len()).map(|v| field.at(VertexId::from(v))).collect();
        let is_visible = field.is_visible;
        ScanNoise { deviation: field.deviation, correlation, is_visible, bias: 0.0, at }
    }

    /// The same beside systematic errors.
    #[must_use]
    pub fn with_bias(self, bias: f64) -> Self {
        ScanNoise { bias, ..self }
    }

    /// The variance of a mean of many neighbouring vertices, as a multiple of that of independent ones.
    pub(crate) fn common(&self) -> f64 {
        let [one, two] = self.correlation;
        1.0 + 6.0 * one + 12.0 * two
    }

    /// The standard deviation at a vertex.
    fn at(&self, v: u32) -> f64 {
        self.at[v as usize]
    }
}

/// Finds the regions of a noisy scan. Triangles of free-form surfaces have none.
///
/// The covariances of the regions are those of their surfaces' motions in the unit of the mesh.
pub fn find_scanned(mesh: &Mesh, noise: &ScanNoise) -> Regions {
    let rings = VertexRings::new(mesh);
    let scan = NoisyScan::new(mesh, &rings, noise);
    let mut room = Room::new(scan.len());
    let mut division = Division::new(scan.len());
    seeds::off_creases(&scan, &mut room, &mut division);
    division.merge(&scan, &mut room);
    division.absorb(&scan, &mut room);
    division.move_borders(&scan);
    division.fit_cores(&scan, &mut room, true);
    if !freeform::is_free_form(&scan, &mut room, &mut division) {
        seeds::anywhere(&scan, &mut room, &mut division);
        for round in 0..ROUNDS {
            if round > 0 {
                blends::find(&scan, &mut room, &mut division);
            }
            division.merge(&scan, &mut room);
            division.absorb(&scan, &mut room);
            division.move_borders(&scan);
            division.fit_cores(&scan, &mut room, true);
        }
        division.merge(&scan, &mut room);
        division.absorb(&scan, &mut room);
        freeform::give_up(&scan, &mut room, &mut division);
    }
    freeform::fill_thin(&scan, &mut division);
    division.fit_cores(&scan, &mut room, false);
    result::gathered(&scan, &EdgeMap::new(mesh), &division)
}

/// The rounds of merging and moving borders. The second changes little.
const ROUNDS: usize = 2;
