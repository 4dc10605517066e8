//! Check of the loops of faces on one surface.
//!
//! Every loop must be closed, lie in the domain and not cross itself or another loop. Inner loops
//! must lie in their outer loop. [`formats::Brep::check`] checks what every boundary representation
//! must satisfy.

use super::FaceBounds;
use crate::error::BrepFault;
use crate::spline::{CertifiedLoop, Nest, crossings, misplaced};

/// Checks the loops of all faces. Loops of different faces must not cross each other, either.
pub(super) fn check(faces: &[FaceBounds]) -> Result<(), BrepFault> {
    let mut outlines = Vec::new();
    let mut names = Vec::new();
    for (face, bounds) in faces.iter().enumerate() {
        // If there is no outer loop, the sides of the surface are loop 0.
        let loops = bounds.outer.iter().map(|l| (0, l)).chain((1..).zip(&bounds.inner));
        for (ring, (pcurves, edges)) in loops {
            if pcurves.len() != edges.len() {
                return Err(BrepFault::Pairs { face, ring });
            }
            let outline = CertifiedLoop::new(pcurves);
            outlines.push(outline.map_err(|(fault, _)| BrepFault::Loop { face, ring, fault })?);
            names.push((face, ring));
        }
    }
    let all: Vec<&CertifiedLoop> = outlines.iter().collect();
    let mut found = crossings(&all);
    let mut rest = &all[..];
    for bounds in faces {
        let first = all.len() - rest.len();
        let (own, others) = rest.split_at(bounds.inner.len() + usize::from(bounds.outer.is_some()));
        let wrong = misplaced(own, &nests(bounds));
        found.extend(wrong.into_iter().map(|(i, place)| (first + i, place)));
        rest = others;
    }
    match found.first() {
        Some(&(i, (fault, _))) => {
            let (face, ring) = names[i];
            Err(BrepFault::Loop { face, ring, fault })
        }
        None => Ok(()),
    }
}

/// The required nesting of a face's loops: the outer loop runs counter-clockwise, and the inner
/// loops run clockwise inside it and outside each other.
fn nests(bounds: &FaceBounds) -> Vec<Nest> {
    let outer = bounds.outer.iter().map(|_| Nest::default());
    let around: Vec<usize> = bounds.outer.iter().map(|_| 0).collect();
    let inner = bounds.inner.iter().map(|_| Nest { around: around.clone(), clockwise: true });
    outer.chain(inner).collect()
}

#[cfg(test)]
mod tests {
    use formats::brep::{BrepElement, ModelFault};

    use super::*;
    use crate::error::Error;
    use crate::geometry::{UvVector, Vector};
    use crate::spline::{Curve, KnotVector, LoopFault, Surface, curve_on_surface};
    use crate::stages::brep::build;

    fn plate() -> Surface {
        let k = KnotVector::uniform(3, 6);
        let net = (0..36).map(|n| Vector::new(k.greville(n / 6), k.greville(n % 6), 0.0));
        Surface::new(k.clone(), k.clone(), net.map(|p| 100.0 * p).collect())
    }

    type TestLoop = (Vec<Curve<2>>, Vec<Curve<3>>);

    /// A triangular loop around (u, 0.5). It runs clockwise, or counter-clockwise if `r` is
    /// negative.
    fn triangle(surface: &Surface, u: f64, r: f64) -> TestLoop {
        let corners = [(-r, -r.abs()), (-r, r.abs()), (r, 0.0)];
        let at = |i: usize| UvVector::new(u + corners[i % 3].0, 0.5 + corners[i % 3].1);
        let side = |i: usize| {
            let points = (0..4).map(|k| at(i).lerp(&at(i + 1), k as f64 / 3.0)).collect();
            Curve::new(KnotVector::clamped(3, &[i as f64, i as f64 + 1.0], 1), points)
        };
        let pcurves: Vec<Curve<2>> = (0..3).map(side).collect();
        let edges = pcurves.iter().map(|c| curve_on_surface(surface, c, 1e-7)).collect();
        (pcurves, edges)
    }

    fn fault(surface: &Surface, inner: &[&TestLoop]) -> Option<BrepFault> {
        let inner = inner.iter().map(|(c, e)| (c.as_slice(), e.as_slice())).collect();
        match build(surface, &[FaceBounds { outer: None, inner }], "plate", 1e-7) {
            Err(Error::Brep(fault)) => Some(fault),
            _ => None,
        }
    }

    #[test]
    fn every_broken_rule_is_named() {
        let plate = plate();
        let good = triangle(&plate, 0.3, 0.1);
        assert_eq!(fault(&plate, &[&good, &triangle(&plate, 0.7, 0.1)]), None);

        let wrong = |inner: &[&TestLoop]| match fault(&plate, inner) {
            Some(BrepFault::Loop { fault, .. }) => Some(fault),
            _ => None,
        };
        let near = triangle(&plate, 0.4, 0.1);
        assert_eq!(wrong(&[&good, &near]), Some(LoopFault::CrossesAnother));
        assert_eq!(wrong(&[&good, &triangle(&plate, 0.29, 0.01)]), Some(LoopFault::Misplaced));
        assert_eq!(wrong(&[&triangle(&plate, 0.05, 0.1)]), Some(LoopFault::Leaves));
        assert_eq!(wrong(&[&triangle(&plate, 0.3, -0.1)]), Some(LoopFault::WrongWay));
        let open = (good.0[..2].to_vec(), good.1[..2].to_vec());
        assert_eq!(wrong(&[&open]), Some(LoopFault::Open));

        let pairs = Some(BrepFault::Pairs { face: 0, ring: 1 });
        assert_eq!(fault(&plate, &[&(good.0.clone(), good.1[..2].to_vec())]), pairs);
        let mut moved = good.clone();
        moved.1[1].control[2].z += 1e-5;
        let off = fault(&plate, &[&moved]);
        assert!(
            matches!(
                off,
                Some(BrepFault::Parts(ModelFault::OffSurface(BrepElement::Use(0, 1, 1), _)))
            ),
            "{off:?}"
        );
        let mut longer = good.clone();
        longer.0[1].knots = KnotVector::clamped(3, &[1.0, 3.0], 1);
        let range = fault(&plate, &[&longer]);
        assert!(
            matches!(range, Some(BrepFault::Parts(ModelFault::Range(BrepElement::Use(0, 1, 1))))),
            "{range:?}"
        );
    }
}
