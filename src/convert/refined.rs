//! More knots in those faces of a body that miss the tolerance.

use super::face_options::FaceOptions;
use super::faces::{Faces, HOLDS};
use super::gaps::Gaps;
use crate::error::Result;
use crate::mesh::Patch;
use crate::stages::refine;

/// Fits the faces again that miss the tolerance, and those with places that are far from the scan. A face that
/// then turns over or goes through another one is held more firmly, and at last put back. Returns the best
/// faces without faults. If the tolerance holds only for the points, nothing is done for the places alone.
pub(super) fn refined(
    faces: Faces,
    patch: &Patch,
    gaps: &Gaps,
    options: &FaceOptions,
) -> Result<Faces> {
    let keeps = |beyond: f64| beyond <= options.outliers;
    if keeps(faces.net.beyond) && (!options.both_ways || keeps(faces.beyond())) {
        return Ok(faces);
    }
    let how = refine::Options {
        tolerance: options.tolerance,
        outliers: options.outliers,
        max_control: options.knots.largest_net() / faces.network.surfaces.len().max(1),
    };
    let mut refinement = refine::refine(&faces.network, faces.samples.clone(), &how)?;
    // Shares of the same points before and after.
    let start = refinement.report();
    let share = |beyond: usize| beyond as f64 / start.measured.max(1) as f64;
    let mut best = (share(start.beyond_before) + faces.beyond(), None);
    for round in 0.. {
        let mut next = faces.clone();
        next.network.clone_from(&refinement.network);
        let (next, faults) = next.checked(patch, gaps, options.tolerance);
        let report = refinement.report();
        let beyond = share(report.beyond) + next.beyond();
        if faults.is_empty() {
            let misses = next.to_scan.misses.clone();
            if beyond <= best.0 {
                best = (beyond, Some(next));
            }
            if !options.both_ways || misses.is_empty() || round >= HOLDS {
                break;
            }
            let wanted: Vec<_> = misses.iter().map(|m| (m.face, m.at, m.wanted)).collect();
            refinement.follow(&wanted);
            continue;
        }
        let mut faulty = report.faces;
        faulty.retain(|face| faults.iter().any(|fault| fault.0 == *face));
        if faulty.is_empty() {
            break;
        }
        match round < HOLDS {
            true => refinement.hold(&faulty),
            false => refinement.put_back(&faulty),
        }
    }
    Ok(best.1.unwrap_or(faces))
}

impl Faces {
    /// The share of the places on the faces that are too far from the scan.
    fn beyond(&self) -> f64 {
        self.to_scan.beyond as f64 / self.to_scan.deviation.distances.len().max(1) as f64
    }
}
