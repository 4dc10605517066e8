//! The bodies of components with exact faces, from what their seams made.

use formats::Brep;
use formats::scene::Placement;

use super::conversion::{Body, BodyFit, ExactFit, FaceSize, Missed};
use super::exact::Exact;
use super::exact_distances::Distances;
use super::input::InputReport;
use super::stage::{Observer, Stage};
use super::{Options, TargetShape};
use crate::deviation::Deviation;
use crate::error::Result;
use crate::mesh::{Choice, Mesh, VertexMap};
use crate::stages::regions::Snap;
use crate::stages::seams::{ClosedGap, FacePatch, Report};
use crate::stages::sharpen::Riser;
use crate::stages::{fill, smooth};

/// What the seams of a component made, and how far it is from the scan. Lengths are in mm.
pub(super) struct ExactBody {
    pub input: InputReport,
    pub shape: TargetShape,
    pub vertices: VertexMap,
    pub brep: Brep,
    /// The mesh whose vertices are on the faces.
    pub mesh: Mesh,
    pub mm: f64,
    /// Where the mesh was put.
    pub placement: Option<Placement>,
    pub report: Report,
    pub gaps: Vec<ClosedGap>,
    pub risers: Vec<Riser>,
    pub snaps: Vec<Snap>,
    pub round_sizes: Vec<FaceSize>,
    pub distances: Distances,
    pub deviation: Deviation,
    /// The tolerance if none is named.
    pub tolerance: f64,
    /// The bound of the errors of the vertices of a clean mesh.
    pub rounding: f64,
    /// The factor by which it is larger than the rounding of the file.
    pub rounding_factor: f64,
    /// The standard deviation of the noise of a scan.
    pub noise: Option<f64>,
}

impl ExactBody {
    pub(super) fn finished(self, options: &Options) -> Body {
        let ExactBody { input, shape, vertices, brep, mesh, mm, distances, deviation, .. } = self;
        // Half a step of each of three numbers is a bound, and steps are spread evenly.
        let noise = self.noise.unwrap_or(self.rounding / 3.0);
        let is_noisy = self.noise.is_some();
        let tolerance = options.tolerance.unwrap_or(self.tolerance);
        Body {
            input,
            smooth: smooth::Report { noise, is_noisy, ..smooth::Report::default() },
            fill: fill::Report::default(),
            trimmed: Vec::new(),
            tolerance,
            tolerance_named: options.tolerance.is_some(),
            spared: 0.0,
            noise,
            missed: Missed::beyond(&deviation, tolerance),
            fit_deviation: deviation.clone(),
            deviation,
            vertex_deviation: None,
            face_to_scan: distances.to_triangles,
            brep,
            origin: [0.0; 3],
            placement: self.placement,
            hints: Vec::new(),
            stand_ins: None,
            vertices,
            shape,
            fit: BodyFit::Exact(Box::new(ExactFit {
                faces: distances.of_faces,
                of_triangle: distances.of_triangle,
                mesh,
                mm,
                facets: self.report.facets,
                free_forms: self.report.free_forms,
                fallbacks: self.report.fallbacks,
                gaps: self.gaps,
                risers: self.risers,
                snaps: self.snaps,
                round_sizes: self.round_sizes,
                explained: distances.explained,
                rounding: self.rounding,
                rounding_factor: self.rounding_factor,
                noise: self.noise,
            })),
        }
    }
}

/// Turns the B-rep of a void and its patches inside out, so that they face into it.
pub(super) fn turned(shape: TargetShape, brep: Brep, patches: &mut [FacePatch]) -> Brep {
    if shape != TargetShape::Void {
        return brep;
    }
    patches.iter_mut().for_each(|patch| patch.side = -patch.side);
    brep.reversed()
}

/// Makes the bodies of components one by one, until one of them fails.
pub(super) fn each<T>(
    found: Vec<(Choice, T)>,
    watch: &mut Observer,
    mut body: impl FnMut(T, &mut Observer) -> Result<std::result::Result<Body, String>>,
) -> Result<Exact> {
    let count = found.len();
    let mut bodies = Vec::with_capacity(count);
    for (number, (component, one)) in found.into_iter().enumerate() {
        watch(Stage::Component(number))?;
        match body(one, watch) {
            Ok(Ok(body)) => {
                watch(Stage::Done(&body))?;
                bodies.push(body);
            }
            Ok(Err(why)) => return Ok(Exact::Failed(why)),
            Err(error) => return Err(error.of_component(component.number(), count)),
        }
    }
    Ok(Exact::Bodies(bodies))
}
