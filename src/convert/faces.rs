//! The faces of a body: layout → net → patches → refine → trim, with a finer layout where faces fail.

use std::sync::atomic::{AtomicBool, Ordering};

use super::face_options::FaceOptions;
use super::gaps::Gaps;
use super::refined::refined;
use super::stage::{Observer, Stage, within};
use crate::deviation::{self, NetworkToScan};
use crate::error::{Error, Result};
use crate::geometry::Point;
use crate::mesh::{FaceOrigin, Patch, QuadMesh};
use crate::spline::{KeptPlaces, Network, NetworkCut, Samples};
use crate::stages::layout::QuadLayout;
use crate::stages::trim::network::CutFault;
use crate::stages::{layout, net, patches};

/// The most rounds in which the layout is made finer. Where the scan tells no more about the shape, further
/// rounds do not help.
const FINER_ROUNDS: usize = 4;

/// The layout is not made finer if several faces are faulty, and more than one in this number of them. Then the parts of the
/// scan are finer than its triangles nearly everywhere, and finer layouts have more faults.
const MOST_FAULTY: usize = 5;

/// A face that leaves the scan by more than this multiple of the tolerance bridges a part that is narrower
/// than its quads. One in `FEW` faces, the farthest ones, are made smaller in a round, so that their
/// number grows only where it helps.
const FAR: f64 = 5.0;
const FEW: usize = 20;

/// The number of places in each span of a track at which the angle between its faces is measured.
pub(super) const SEAM_PLACES: usize = 4;

/// The most times that a surface is held more firmly to its layout near faults. Each makes it eight times
/// as firm.
pub(super) const HOLDS: usize = 4;

/// The faces of a body, in the lengths of its mesh.
#[derive(Clone)]
pub(super) struct Faces {
    pub network: Network,
    pub cut: NetworkCut,
    /// Why the gaps cannot be cut out.
    uncut: Option<CutFault>,
    pub to_scan: NetworkToScan,
    pub layout: layout::Report,
    pub net: net::Report,
    pub irregular: usize,
    /// The quads of each face.
    pub quads: QuadMesh,
    /// The points of each face.
    pub samples: Vec<Samples>,
}

/// Makes the faces of a filled body with even triangles. The layout is made finer where they turn over or
/// go through each other, and then, unless a number of faces is wanted, where they are far from the
/// scan. Then single faces are refined. A gap that cannot be cut out even of finer faces stays filled.
pub(super) fn faces(
    patch: &Patch,
    gaps: &mut Gaps,
    options: &FaceOptions,
    watch: &mut Observer,
) -> Result<Faces> {
    let is_stopped = AtomicBool::new(false);
    let watch: &mut Observer =
        &mut |stage| watch(stage).inspect_err(|_| is_stopped.store(true, Ordering::Relaxed));
    let how = layout::Options { blocks: options.wanted, ..layout::Options::default() };
    let mut layout = layout::layout_with(&patch.mesh, &how, &mut within("layout", watch))?;
    let mut made = Some(faces_of(&layout, patch, gaps, options, watch)?);
    let mut best: Option<Faces> = None;
    let mut round = 0;
    while let Some((faces, faults)) = made {
        let blocks = if faults.is_empty() {
            let off = |faces: &Faces| faces.to_scan.deviation.max;
            if best.as_ref().is_some_and(|best| off(&faces) >= off(best)) {
                break;
            }
            let far = faces.far(FAR * options.tolerance);
            best = Some(faces);
            if options.wanted.is_some() { Vec::new() } else { far }
        } else if best.is_some() {
            break;
        } else {
            let blocks = faulty_blocks(&faults, faces.network.surfaces.len());
            let blocks = blocks.filter(|_| round < FINER_ROUNDS);
            round += usize::from(blocks.is_some());
            let smaller =
                |blocks: Vec<usize>| finer(&mut layout, &blocks, patch, gaps, options, watch);
            made = match blocks.map(smaller).transpose()?.flatten() {
                None => Some(faces.without_gap(&faults, gaps, patch, options.tolerance)?),
                smaller => smaller,
            };
            continue;
        };
        if blocks.is_empty() || round == FINER_ROUNDS {
            break;
        }
        round += 1;
        made = match finer(&mut layout, &blocks, patch, gaps, options, watch) {
            Err(error) if is_stopped.load(Ordering::Relaxed) => return Err(error),
            // Sound faces are there, and a finer layout has none.
            made => made.ok().flatten(),
        };
    }
    let best = best.ok_or(Error::Layout("no block of it can be made smaller"))?;
    refined(best, patch, gaps, options)
}

/// The blocks of faulty faces, which should be smaller. `None` if too many of the faces are faulty.
fn faulty_blocks(faults: &[FacesFault], faces: usize) -> Option<Vec<usize>> {
    let mut blocks: Vec<usize> = faults.iter().map(|fault| fault.0).collect();
    blocks.sort_unstable();
    blocks.dedup();
    (blocks.len() <= (faces / MOST_FAULTY).max(1)).then_some(blocks)
}

/// The faces of a layout with some smaller blocks. `None` if none of them can be made smaller.
fn finer(
    layout: &mut QuadLayout,
    blocks: &[usize],
    patch: &Patch,
    gaps: &Gaps,
    options: &FaceOptions,
    watch: &mut Observer,
) -> Result<Option<(Faces, Vec<FacesFault>)>> {
    let is_finer = layout.split(blocks, &mut within("layout", watch))?;
    is_finer.then(|| faces_of(layout, patch, gaps, options, watch)).transpose()
}

/// Makes the faces of a layout. Returns also those that turn over or go through each other, with places.
/// Near them the surface is held to the layout.
fn faces_of(
    layout: &QuadLayout,
    patch: &Patch,
    gaps: &Gaps,
    options: &FaceOptions,
    watch: &mut Observer,
) -> Result<(Faces, Vec<FacesFault>)> {
    watch(Stage::Layout(layout.quads()))?;
    let how = options.net(layout.quads())?;
    let mut fit = net::fit_with(layout.quads(), patch, &how, &mut within("fit", watch))?;
    let mut best = faces_of_net(&fit, layout, patch, gaps, options.tolerance)?;
    for _ in 0..HOLDS {
        if best.1.is_empty() || best.0.uncut.is_some() {
            break;
        }
        fit.hold(&best.1)?;
        let held = faces_of_net(&fit, layout, patch, gaps, options.tolerance)?;
        if held.1.len() >= best.1.len() {
            break;
        }
        best = held;
    }
    Ok(best)
}

/// A face that turns over or goes through another one, and a place there.
pub(super) type FacesFault = (usize, Point);

/// Cuts a fitted surface into faces, and checks them.
fn faces_of_net(
    fit: &net::NetFit,
    layout: &QuadLayout,
    patch: &Patch,
    gaps: &Gaps,
    tolerance: f64,
) -> Result<(Faces, Vec<FacesFault>)> {
    let quads = fit.net.mesh.clone();
    let (network, extracted) = patches::extract(&quads, &fit.net.surface)?;
    let faces = Faces {
        network,
        cut: NetworkCut::default(),
        uncut: None,
        to_scan: NetworkToScan::default(),
        layout: layout.report(),
        net: fit.report.clone(),
        irregular: extracted.irregular,
        quads,
        samples: fit.samples(),
    };
    Ok(faces.checked(patch, gaps, tolerance))
}

/// The places of seams at which two faces meet at more than a right angle. One of them turns over there,
/// between the samples of its inside.
fn folded_seams(network: &Network, kept: &KeptPlaces) -> Vec<FacesFault> {
    let seams = network.seams(SEAM_PLACES).into_iter();
    let folded = seams.filter(|place| {
        place.angle > std::f64::consts::FRAC_PI_2 && kept.contains(place.face, place.at)
    });
    folded.map(|place| (place.face, network.surfaces[place.face].point(place.at))).collect()
}

impl Faces {
    /// Cuts the gaps out of the faces and compares them with the scan. Returns also the faults.
    pub(super) fn checked(
        mut self,
        patch: &Patch,
        gaps: &Gaps,
        tolerance: f64,
    ) -> (Self, Vec<FacesFault>) {
        let is_measured: Vec<bool> =
            patch.origin.iter().map(|&origin| origin == FaceOrigin::Measured).collect();
        let (network, quads) = (&self.network, &self.quads);
        (self.cut, self.uncut) = match gaps.cut(network) {
            Ok(cut) => (cut, None),
            Err(fault) => (NetworkCut::none(network), Some(fault)),
        };
        let kept = self.cut.kept_places(network);
        let mesh = &patch.mesh;
        self.to_scan =
            deviation::network_to_scan(network, &kept, quads, mesh, &is_measured, tolerance);
        let mut faults = self.to_scan.inverted.clone();
        match &self.uncut {
            // Without loops nobody knows which faults count.
            Some(fault) => faults = vec![(fault.surface, fault.at)],
            None => {
                faults.extend(deviation::crossing_faces(network, &kept));
                faults.extend(folded_seams(network, &kept));
            }
        }
        (self, faults)
    }

    /// The same faces with the gap filled that cannot be cut out, if that is their fault.
    fn without_gap(
        self,
        faults: &[FacesFault],
        gaps: &mut Gaps,
        patch: &Patch,
        tolerance: f64,
    ) -> Result<(Self, Vec<FacesFault>)> {
        match &self.uncut {
            Some(fault) if gaps.leave(fault) => Ok(self.checked(patch, gaps, tolerance)),
            _ => Err(self.refused(faults)),
        }
    }

    /// Why faces with some faults are none.
    fn refused(self, faults: &[FacesFault]) -> Error {
        let at = faults.first().map_or(Point::origin(), |fault| fault.1);
        self.uncut.map_or(Error::BodyFolds { count: faults.len(), at }, Error::from)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_faulty_face_is_never_too_many() {
        let at = Point::origin();
        assert_eq!(faulty_blocks(&[(2, at), (2, at)], 4), Some(vec![2]));
        assert_eq!(faulty_blocks(&[(2, at), (1, at)], 4), None);
        assert_eq!(faulty_blocks(&[(2, at), (1, at)], 10), Some(vec![1, 2]));
    }
}
