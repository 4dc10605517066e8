//! The solid against the mesh: a face on the wrong side of its border has a wrong area, and the solid a wrong volume.

use formats::Brep;
use formats::brep::{FaceId, ShellId};

use super::{SeamFault, Work};
use crate::geometry::Point;
use crate::primitives::PrimitiveKind;

/// A true face and its triangles differ in area by less than this factor: a ring of nine chords has 0.97 of its circle's
/// length, its disc 0.92 of the area, and a sphere of such chords 0.9. A face that takes the wrong way around has twice
/// or a half.
const AREAS: f64 = 1.3;

/// The volume agrees with its bounds to this share: rounding of the integrals.
const INTEGRALS: f64 = 1e-6;

impl Work<'_> {
    /// Compares areas of faces and the volume with the mesh.
    pub(super) fn guard(&self, brep: &Brep) -> Result<(), SeamFault> {
        let mut worst: (f64, Vec<usize>) = (0.0, Vec::new());
        for (i, patch) in self.patches.iter().enumerate() {
            if patch.surface.kind() == PrimitiveKind::Plane {
                continue;
            }
            let own = brep.face_area(FaceId(i));
            let triangles = patch.triangles.iter().map(|&t| self.mesh.triangles[t as usize]);
            let meshed: f64 = triangles.map(|t| 0.5 * self.mesh.area_vector(t).norm()).sum();
            let ratio = own / meshed.max(f64::MIN_POSITIVE);
            if !(ratio < AREAS && ratio > 1.0 / AREAS) {
                return Err(SeamFault::new(&[i], format!("its area is {ratio:.3} of the mesh's")));
            }
            if (ratio - 1.0).abs() > worst.0 {
                worst = ((ratio - 1.0).abs(), vec![i]);
            }
        }
        let volume = brep.volume(ShellId(0));
        let [low, high] = self.volumes();
        if volume < low || volume > high {
            let why = format!("the volume {volume} is not between {low} and {high}");
            return Err(SeamFault::new(&worst.1, why));
        }
        Ok(())
    }

    /// The bounds of the volume: that of the mesh, and each triangle's area times its largest distance from the surface
    /// on either side.
    fn volumes(&self) -> [f64; 2] {
        let (mut volume, mut size) = (0.0, 0.0);
        let (mut low, mut high) = (0.0, 0.0);
        for patch in &self.patches {
            for &t in &patch.triangles {
                let [a, b, c] = self.mesh.corners(self.mesh.triangles[t as usize]);
                let cone = a.coords.dot(&b.coords.cross(&c.coords)) / 6.0;
                volume += cone;
                size += cone.abs();
                let area = 0.5 * (b - a).cross(&(c - a)).norm();
                let middle = Point::from((a.coords + b.coords + c.coords) / 3.0);
                let places = [
                    middle,
                    (a + b.coords) * 0.5,
                    (b + c.coords) * 0.5,
                    (c + a.coords) * 0.5,
                    a,
                    b,
                    c,
                ];
                let offs = places.map(|p| patch.side * patch.surface.distance(p).0);
                // Where the mesh is outside, the solid is smaller.
                low += area * offs.iter().copied().fold(0.0, f64::max);
                high -= area * offs.iter().copied().fold(0.0, f64::min);
            }
        }
        let slack = INTEGRALS * size;
        [volume - low - slack, volume + high + slack]
    }
}
