//! The content of the pictures: a conversion and the meshes of its stages.

use std::path::Path;

use scan2step::geometry::{Point, Uv};
use scan2step::mesh::Disk;
use scan2step::report::picture::{outlines, polyline};
use scan2step::spline::Surface;
use scan2step::stages::brep;
use scan2step::stages::parameterize::Parameterized;
use scan2step::{Body, Options, Stage};

use crate::body::{OneFace, face_seen};

/// A converted scan.
pub struct Scene {
    /// The repaired measured mesh.
    pub measured: Disk,
    /// The smoothed mesh.
    pub smoothed: Disk,
    /// The filled mesh with its parameter points.
    pub map: Parameterized,
    /// The face and its quality.
    pub conversion: Body,
}

impl Scene {
    /// Reads and converts a scan.
    pub fn of(path: &Path) -> Result<Scene, Box<dyn std::error::Error>> {
        let soup = formats::read_scan(path)?;
        let options = Options::default();
        let (mut measured, mut smoothed, mut map) = (None, None, None);
        let conversion = face_seen(&soup, &options, &mut |stage| {
            match stage {
                Stage::Mesh(disk) => measured = Some(disk.clone()),
                Stage::Smooth(disk) => smoothed = Some(disk.clone()),
                Stage::Parameterize(parameterized, _) => map = Some(parameterized.clone()),
                _ => {}
            }
            Ok(())
        })?;
        let measured = measured.ok_or("the conversion showed no mesh")?;
        let smoothed = smoothed.ok_or("the conversion showed no smoothed mesh")?;
        let map = map.ok_or("the conversion showed no parameterization")?;
        Ok(Scene { measured, smoothed, map, conversion })
    }

    /// The fitted surface.
    pub fn surface(&self) -> &Surface {
        &self.conversion.one().surface
    }

    /// The points that must be in the picture: those of the scan and of the face's edges.
    pub fn extent(&self) -> impl Iterator<Item = Point> {
        self.measured.mesh.points.iter().copied().chain(self.edges().into_iter().flatten())
    }

    /// The four sides of the patch as polylines.
    pub fn edges(&self) -> Vec<Vec<Point>> {
        let edges = brep::outer_edges(self.surface());
        edges
            .iter()
            .map(|(edge, _, _)| polyline(edge).into_iter().map(Point::from).collect())
            .collect()
    }

    /// The trim loops in the parameter plane as closed polylines.
    pub fn loops(&self) -> Vec<Vec<Uv>> {
        outlines(&self.conversion.one().loops)
    }
}
