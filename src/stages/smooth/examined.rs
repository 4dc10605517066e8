//! What smoothing finds out about a scan before it moves anything, and where it must not.

use rayon::prelude::*;

use super::levels::{self, SupportLevel};
use super::support;
use super::surface::MlsSurface;
use crate::error::{Error, Result};
use crate::geometry::VertexId;
use crate::mesh::{Mesh, VertexRings};
use crate::noise::NoiseField;
use crate::progress::{self, Progress};
use crate::statistics::{CALM, absolute_at, quantile};

/// A fixed support must be able to smooth at least this share of the points.
const MOST_REACHED: f64 = 0.5;

/// The noise and the outliers of a scan.
pub(crate) struct Examined {
    rings: VertexRings,
    pub noise: NoiseField,
    /// Whether each vertex is an outlier.
    pub left_out: Vec<bool>,
}

impl Examined {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let rings = VertexRings::new(mesh);
        let noise = NoiseField::new(mesh, &rings);
        let left_out = noise.outliers(mesh, &rings);
        Examined { rings, noise, left_out }
    }

    /// The surface with the supports that are found on the scan.
    pub(super) fn surface(&self, mesh: &Mesh, progress: &mut Progress) -> Result<MlsSurface> {
        let levels = levels::levels(mesh, &self.rings, &self.noise, &self.left_out);
        let place =
            support::choose(mesh, &levels, &self.noise, &mut progress::step(progress, 0, 2))?;
        let normals = levels[0].clusters.normals.clone();
        MlsSurface::new(normals, levels, place, &mut progress::step(progress, 1, 2))
    }

    /// The surface with one support everywhere.
    pub(crate) fn surface_of(&self, mesh: &Mesh, h: f64) -> Result<MlsSurface> {
        let finest = SupportLevel::finest(mesh, &self.rings, &self.left_out);
        let level = finest.next(h);
        let place = vec![0.0; mesh.points.len()];
        let none = &mut progress::ignore;
        let surface = MlsSurface::new(finest.clusters.normals.clone(), vec![level], place, none)?;
        if surface.reached(mesh) < MOST_REACHED * mesh.points.len() as f64 {
            return Err(Error::Support { h, shortest: finest.h, longest: mesh.diagonal() });
        }
        Ok(surface)
    }

    /// The vertices at which a surface misses the shape, as along a sharp edge: it is farther from
    /// them and their neighbours than noise explains. `offsets` are its distances along the normal. A narrow support follows a part of the noise, so
    /// the usual distances of a level count where these are smaller. Outliers say nothing.
    pub(super) fn shape(&self, mesh: &Mesh, surface: &MlsSurface, offsets: &[f64]) -> Vec<bool> {
        let count = offsets.len();
        let relative = |v: usize| {
            let noise = self.noise.at(VertexId::from(v));
            if self.left_out[v] { 0.0 } else { (offsets[v] / noise).powi(2) }
        };
        let mut squares: Vec<f64> = (0..count).into_par_iter().map(relative).collect();
        for vertices in surface.by_level() {
            let mut all: Vec<f64> = vertices.iter().map(|&v| squares[v]).collect();
            let usual = quantile(&mut all, CALM).unwrap_or(0.0) / absolute_at(CALM).powi(2);
            vertices.iter().for_each(|&v| squares[v] /= usual.clamp(f64::MIN_POSITIVE, 1.0));
        }
        let around = |v: usize| self.rings.neighbours(mesh, VertexId::from(v)).map(VertexId::index);
        self.noise.unexplained(&squares, around)
    }
}
