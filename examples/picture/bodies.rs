//! Pictures of the stages of a body: its layout of quads, and its faces.

use std::path::Path;

use scan2step::geometry::{Point, VertexId};
use scan2step::mesh::{Components, Mesh, QuadMesh, from_soup};
use scan2step::report::picture::camera::Camera;
use scan2step::report::picture::canvas::Canvas;
use scan2step::report::picture::colour::{DOTS, INK, Rgb, TINTS, linear, srgb};
use scan2step::report::picture::image::Image;
use scan2step::report::picture::lines::{Lines, Pen};
use scan2step::report::picture::{occlusion, polyline, sheet};
use scan2step::spline::Network;
use scan2step::{BodyFit, Options, Stage, TargetShape, deviation};

use crate::body::body_of;

const QUADS: Pen = Pen { seen: 0.45, ..Pen::solid(0.8) };
const SEAM: Pen = Pen::solid(2.1);

/// The size of the dots at irregular vertices.
const DOT: Pen = Pen::solid(7.0);

/// A body and what its stages made.
pub struct Body {
    layout: QuadMesh,
    network: Network,
}

impl Body {
    /// Reads and converts a closed scan.
    pub fn of(path: &Path) -> Result<Body, Box<dyn std::error::Error>> {
        let scan = Components::new(from_soup(&formats::read_scan(path)?, 1.0)?);
        let mut layout = None;
        let mut watch = |stage: Stage| {
            if let Stage::Layout(quads) = stage {
                layout = Some(quads.clone());
            }
            Ok(())
        };
        let made = body_of(&scan, TargetShape::Solid, &Options::default(), &mut watch)?;
        let layout = layout.ok_or("the conversion showed no layout")?;
        let BodyFit::Network(fit) = made.fit else { return Err("one face".into()) };
        let network = fit.network;
        Ok(Body { layout, network })
    }

    /// The quads of the layout, each block with its tint, and a dot at each irregular vertex.
    pub fn layout(&self, size: [usize; 2]) -> Image {
        let quads = &self.layout;
        let triangles = quads.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let mesh = Mesh { points: quads.points.clone(), triangles: triangles.collect() };
        let per_block = 2 * quads.side * quads.side;
        let (mut canvas, camera) = tinted(&mesh, |triangle| triangle / per_block, size);
        let project = |v: VertexId| camera.project(&mesh.point(v));
        let mut lines = Lines::over(&canvas);
        let mut seams = Lines::over(&canvas);
        for &[a, b, c, d] in &quads.quads {
            lines.polyline(&canvas, [a, b, c, d, a].into_iter().map(project), QUADS);
        }
        for (block, k) in (0..4 * quads.blocks()).map(|side| (side / 4, side % 4)) {
            let n = quads.side;
            let side = (0..=n).map(|t| match k {
                0 => quads.vertex(block, t, 0),
                1 => quads.vertex(block, n, t),
                2 => quads.vertex(block, t, n),
                _ => quads.vertex(block, 0, t),
            });
            seams.polyline(&canvas, side.map(project), SEAM);
        }
        let valences = quads.valences().into_iter().enumerate();
        let irregular: Vec<VertexId> =
            valences.filter(|of| of.1 != 4).map(|of| VertexId::from(of.0)).collect();
        let mut dots = Lines::over(&canvas);
        irregular.iter().for_each(|&v| dots.point(&canvas, project(v), DOT));
        lines.ink(&mut canvas, linear(INK));
        seams.ink(&mut canvas, linear(INK));
        dots.ink(&mut canvas, linear(DOTS));
        canvas.image()
    }

    /// The faces, each with its tint, and the seams between them.
    pub fn faces(&self, size: [usize; 2]) -> Image {
        let (mesh, faces) = deviation::tessellation(&self.network);
        let (mut canvas, camera) = tinted(&mesh, |triangle| faces[triangle].0, size);
        let mut seams = Lines::over(&canvas);
        for track in &self.network.tracks {
            let points = polyline(&track.curve).into_iter().map(Point::from);
            seams.polyline(&canvas, points.map(|p| camera.project(&p)), SEAM);
        }
        let mut dots = Lines::over(&canvas);
        let irregular = self.network.irregular();
        irregular.iter().for_each(|p| dots.point(&canvas, camera.project(p), DOT));
        seams.ink(&mut canvas, linear(INK));
        dots.ink(&mut canvas, linear(DOTS));
        canvas.image()
    }
}

/// A mesh whose parts have different tints.
fn tinted(mesh: &Mesh, part: impl Fn(usize) -> usize, size: [usize; 2]) -> (Canvas, Camera) {
    let camera = Camera::facing(mesh, mesh.points.iter().copied(), size);
    let mut canvas = Canvas::new(size);
    sheet::draw(&mut canvas, mesh, &camera, |triangle, _, normal, _| -> Rgb {
        let light = 0.45 + 0.55 * normal.z.abs() as f32;
        linear(srgb(TINTS[part(triangle) % TINTS.len()])).map(|c| c * light)
    });
    occlusion::darken(&mut canvas);
    (canvas, camera)
}
