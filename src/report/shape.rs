//! The figures of the shape that a scan became, and of each of its faces.

use formats::Brep;
use formats::brep::{BrepSurface, ShellId};

use super::{SurfaceFigures, UncertaintyFigures};
use crate::convert::{Body, ExactFace, ExactFit, NetworkFit, Seams};

/// The shape that a scan became.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct ShapeFigures {
    /// "face", "solid", "void" or "shell".
    pub kind: &'static str,
    /// The number of solids.
    pub solids: usize,
    /// The number of shells.
    pub shells: usize,
    /// The number of faces.
    pub faces: usize,
    /// The number of edges.
    pub edges: usize,
    /// The number of edges that only one face uses.
    pub free_edges: usize,
    /// The number of vertices.
    pub vertices: usize,
    /// The number of vertices at which other than four faces meet.
    pub irregular_vertices: usize,
    /// The number of control points of all faces.
    pub control_points: usize,
    /// The number of surfaces of each kind.
    pub surfaces: SurfaceCounts,
    /// The area of all faces.
    pub area_mm2: f64,
    /// The enclosed volume of a solid.
    pub volume_mm3: Option<f64>,
    /// The angles between neighbouring faces.
    pub seam_deg: SeamFigures,
    /// The number of places at which faces turn over.
    pub folds: usize,
    /// Why the shape is not the first one that was tried. The caller fills it in.
    pub fallback: Option<String>,
}

/// The number of surfaces of each kind.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SurfaceCounts {
    /// B-spline surfaces.
    pub spline: usize,
    /// Planes.
    pub plane: usize,
    /// Cylinders.
    pub cylinder: usize,
    /// Cones.
    pub cone: usize,
    /// Spheres.
    pub sphere: usize,
    /// Tori.
    pub torus: usize,
    /// Surfaces of linear extrusion.
    pub extrusion: usize,
    /// Surfaces of revolution.
    pub revolution: usize,
}

impl SurfaceCounts {
    /// The surfaces of a B-rep.
    pub fn of(brep: &Brep) -> Self {
        let mut counts = SurfaceCounts::default();
        for surface in &brep.surfaces {
            *match surface {
                BrepSurface::Spline(_) => &mut counts.spline,
                BrepSurface::Plane { .. } => &mut counts.plane,
                BrepSurface::Cylinder { .. } => &mut counts.cylinder,
                BrepSurface::Cone { .. } => &mut counts.cone,
                BrepSurface::Sphere { .. } => &mut counts.sphere,
                BrepSurface::Torus { .. } => &mut counts.torus,
                BrepSurface::Extrusion { .. } => &mut counts.extrusion,
                BrepSurface::Revolution { .. } => &mut counts.revolution,
                _ => continue,
            } += 1;
        }
        counts
    }

    /// Each kind with its number of faces.
    pub fn named(&self) -> [(&'static str, usize); 8] {
        [
            ("plane", self.plane),
            ("cylinder", self.cylinder),
            ("cone", self.cone),
            ("sphere", self.sphere),
            ("torus", self.torus),
            ("extrusion", self.extrusion),
            ("revolution", self.revolution),
            ("spline", self.spline),
        ]
    }
}

/// Angles between neighbouring faces, in degrees.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct SeamFigures {
    /// The mean.
    pub mean: f64,
    /// The 95th percentile.
    pub p95: f64,
    /// The largest.
    pub max: f64,
}

/// One face of several.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PatchFigures {
    /// The kind of its surface: "spline", "plane", "cylinder", "cone", "sphere" or "torus".
    pub surface: &'static str,
    /// The number of control points along u and v; `None` if the surface has none.
    pub net: Option<[usize; 2]>,
    /// The root mean square distance of the smoothed points that are nearest to this face. Of an exact face: of
    /// its vertices.
    pub rms_mm: f64,
    /// The largest of their distances.
    pub max_mm: f64,
    /// The number of these points.
    pub points: usize,
    /// The parameters of an exact surface.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub parameters: Option<SurfaceFigures>,
    /// How exactly a scan tells them.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub standard_deviations: Option<UncertaintyFigures>,
}

impl ShapeFigures {
    /// The figures of a body.
    pub(super) fn of(body: &Body) -> Self {
        let control_points = body.surfaces().iter().map(|surface| surface.net.len()).sum();
        let of_brep = Self::of_brep(&body.brep, body.shape.word());
        let figures = ShapeFigures { control_points, volume_mm3: body.volume(), ..of_brep };
        let Some(fit) = body.network() else { return figures };
        let Seams { mean, p95, max } = fit.seams;
        ShapeFigures {
            irregular_vertices: fit.irregular,
            seam_deg: SeamFigures { mean, p95, max },
            folds: fit.folds,
            ..figures
        }
    }

    /// What a B-rep tells.
    fn of_brep(brep: &Brep, kind: &'static str) -> Self {
        let uses = brep.uses();
        ShapeFigures {
            kind,
            solids: brep.solids.len(),
            shells: brep.shells.len(),
            faces: brep.faces.len(),
            edges: brep.edges.len(),
            free_edges: uses.iter().filter(|uses| uses.len() == 1).count(),
            vertices: brep.vertices.len(),
            irregular_vertices: 0,
            control_points: 0,
            surfaces: SurfaceCounts::of(brep),
            area_mm2: (0..brep.shells.len()).map(|shell| brep.area(ShellId(shell))).sum(),
            volume_mm3: None,
            seam_deg: SeamFigures::default(),
            folds: 0,
            fallback: None,
        }
    }
}

impl PatchFigures {
    /// The figures of all exact faces.
    pub(super) fn exact(fit: &ExactFit) -> Vec<Self> {
        let face = |face: &ExactFace| PatchFigures {
            surface: if face.is_free { "spline" } else { face.surface.kind().name() },
            net: None,
            rms_mm: face.rms,
            max_mm: face.max,
            points: face.points,
            parameters: (!face.is_free).then(|| SurfaceFigures::of(&face.surface)),
            standard_deviations: face
                .uncertainty
                .map(|of| UncertaintyFigures::of(&face.surface, &of)),
        };
        fit.faces.iter().map(face).collect()
    }

    /// The figures of all faces of a network.
    pub(super) fn all(body: &Body, fit: &NetworkFit) -> Vec<Self> {
        let face = |(number, face): (usize, &crate::spline::KeptFace)| {
            let surface = &fit.network.surfaces[face.surface];
            let (points, rms_mm, max_mm) = body.fit_deviation.of_face(number);
            let net = [surface.u.functions(), surface.v.functions()];
            PatchFigures {
                surface: "spline",
                net: Some(net),
                rms_mm,
                max_mm,
                points,
                parameters: None,
                standard_deviations: None,
            }
        };
        fit.cut.faces.iter().enumerate().map(face).collect()
    }
}
