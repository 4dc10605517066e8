//! The scan of a report: its file, and the component that was converted or looked at.

use formats::points::Note;
use formats::{LengthUnit, Points, Soup};

use super::hints::likely_units;
use super::{CloudFigures, CloudMeshFigures, SurfaceCounts};
use crate::convert::{ExactEstimate, InputReport, Inspection, Options, PieceReport, TargetShape};
use crate::mesh::{Handle, Repairs};
use crate::primitives::PrimitiveKind;
use crate::stages::cloud;

/// A scan as it was read.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanSource {
    /// The file as the caller named it.
    pub file: String,
    /// The unit of its numbers.
    pub unit: LengthUnit,
    /// Whether neither the file nor the caller names the unit.
    pub unit_assumed: bool,
    /// Vertices of the file, as they are before any repair.
    pub vertices: usize,
    /// Triangles of the file. A polygon of n corners counts as n − 2.
    pub triangles: usize,
    /// Where places are measured from in the scan's own frame, in mm.
    pub origin_mm: [f64; 3],
    /// The cloud, if the file holds points without triangles.
    pub cloud: Option<CloudFigures>,
}

impl ScanSource {
    /// The scan that `soup` was read from, with the unit that a conversion with these options
    /// takes. A length that is no unit of its own ([`Builder::unit_mm`](crate::convert::Builder::unit_mm))
    /// counts as millimetres.
    pub fn of(file: impl Into<String>, soup: &Soup, options: &Options) -> Self {
        let declared = options.unit().or(soup.unit);
        let mm = options.unit_of(soup.unit);
        ScanSource {
            file: file.into(),
            unit: declared.unwrap_or(LengthUnit::Millimetre),
            origin_mm: soup.round_origin(mm).map(|x| mm * x),
            unit_assumed: declared.is_none(),
            vertices: soup.points.len(),
            triangles: soup.polygons.triangle_count(),
            cloud: None,
        }
    }

    /// The same for a cloud of points. Its vertices are its points. Formats that name no unit, but
    /// whose programs write metres, count as formats whose unit is assumed.
    pub fn of_cloud(file: impl Into<String>, cloud: &Points, options: &Options) -> Self {
        let declared = options.unit().or(cloud.unit);
        let unit = declared.unwrap_or(LengthUnit::Millimetre);
        let by_custom = cloud.notes.contains(&Note::MetresByCustom) && options.unit().is_none();
        ScanSource {
            file: file.into(),
            unit,
            unit_assumed: declared.is_none() || by_custom,
            vertices: cloud.len(),
            triangles: 0,
            origin_mm: cloud.origin.map(|x| unit.in_mm() * x),
            cloud: Some(CloudFigures::of(cloud, unit.in_mm())),
        }
    }

    /// The same once a mesh was made of the cloud.
    #[must_use]
    pub fn meshed(mut self, report: &cloud::Report) -> Self {
        if let Some(cloud) = &mut self.cloud {
            cloud.mesh = Some(CloudMeshFigures::of(report, self.unit.in_mm()));
        }
        self
    }
}

/// The scan's file and the component of it.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct InputFigures {
    /// The file as the caller named it.
    pub file: String,
    /// The symbol of the unit of its numbers.
    pub units: &'static str,
    /// Whether neither the file nor the caller names the unit.
    pub units_assumed: bool,
    /// Vertices of the file, as they are before any repair.
    pub file_vertices: usize,
    /// Triangles of the file. A polygon of n corners counts as n − 2.
    pub file_triangles: usize,
    /// Where all places are measured from in the mesh's own frame, if it is far from zero. That of a cloud is in
    /// `cloud`.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub origin_mm: Option<[f64; 3]>,
    /// Points of the file, if it holds a cloud.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub points: Option<usize>,
    /// How a mesh was made of the cloud: along the "grid" of the scan, or by the "stars" of its
    /// points.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub mesher: Option<&'static str>,
    /// The cloud, if the file holds one.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub cloud: Option<CloudFigures>,
    /// Vertices of the component.
    pub vertices: usize,
    /// Triangles of the component.
    pub triangles: usize,
    /// The number of the component, where the largest one is 0.
    pub component: usize,
    /// Components of the scan.
    pub components: usize,
    /// Other components that lie in the holes of this one and belong to the face.
    pub islands: usize,
    /// Triangles of these.
    pub island_triangles: usize,
    /// Boundary loops of the component.
    pub boundary_loops: usize,
    /// The lowest and the highest coordinates of the component.
    pub bounds_mm: [[f64; 3]; 2],
    /// What was repaired: kind and count.
    pub repairs: Repairs,
    /// The handles and tunnels that were cut.
    pub handles_cut: Vec<HandleFigures>,
}

/// A handle or a tunnel.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct HandleFigures {
    /// The middle of its loop.
    pub at: [f64; 3],
    /// The length of its loop.
    pub length_mm: f64,
}

impl HandleFigures {
    fn of(handle: &Handle) -> Self {
        HandleFigures { at: handle.at.coords.into(), length_mm: handle.length }
    }
}

impl InputFigures {
    /// The figures of one component of a scan.
    pub fn of(input: &InputReport, source: &ScanSource) -> Self {
        InputFigures {
            file: source.file.clone(),
            units: source.unit.symbol(),
            units_assumed: source.unit_assumed,
            file_vertices: source.vertices,
            file_triangles: source.triangles,
            origin_mm: Some(source.origin_mm)
                .filter(|origin| source.cloud.is_none() && *origin != [0.0; 3]),
            points: source.cloud.as_ref().map(|cloud| cloud.points),
            mesher: source.cloud.as_ref().and_then(|cloud| Some(cloud.mesh.as_ref()?.mesher)),
            cloud: source.cloud.clone(),
            vertices: input.vertices,
            triangles: input.triangles,
            component: input.component,
            components: input.components,
            islands: input.islands,
            island_triangles: input.island_triangles,
            boundary_loops: input.boundary_loops,
            bounds_mm: input.bounds,
            repairs: input.repairs.clone(),
            handles_cut: input.handles.iter().map(HandleFigures::of).collect(),
        }
    }
}

/// What a component of a scan is, without a conversion: the report of `inspect`.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct InspectionFigures {
    /// The scan's file and the component.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub input: InputFigures,
    /// The genus: handles of a two-sided surface, a whole number; half the cross-caps of a
    /// one-sided surface.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize_genus"))]
    pub genus: f64,
    /// Whether the surface has two sides.
    pub orientable: bool,
    /// Whether the surface is a disk with holes, and can become a face.
    pub disk: bool,
    /// What a conversion makes of it: "face", "shell", "solid", or nothing.
    pub shape: Option<&'static str>,
    /// Why it becomes this shape, if nobody names one.
    pub shape_reason: &'static str,
    /// About the tolerance that a conversion chooses if nobody names one.
    pub tolerance_mm: f64,
    /// Where the outer boundary of a face goes: the four "sides" of the surface, or, as it is ragged, a
    /// "trimmed" loop. Sides that stretch the map too much become a trimmed loop, too.
    pub outline: Option<&'static str>,
    /// The units that the size of the scan suggests, likeliest first, if the assumed one makes it
    /// unlikely.
    pub likely_units: Vec<&'static str>,
    /// The largest components, if there are several.
    pub pieces: Vec<PieceFigures>,
    /// About how many faces a solid or a shell gets.
    pub faces_about: Option<usize>,
    /// The exact faces that it becomes, if it is the mesh of a CAD program or the scan of a part.
    pub exact: Option<EstimateFigures>,
    /// The handles and tunnels that a solid or a shell keeps. Their loops run along the edges of a coarse mesh.
    pub handles: Vec<HandleFigures>,
    /// The boundary loops. The list is empty for a one-sided surface.
    pub loops: Vec<RimFigures>,
    /// Triangles in the components left out.
    pub left_out_triangles: usize,
    /// Standard deviation of the noise along the normal.
    pub noise_mm: f64,
}

/// The exact faces that the mesh of a CAD program or the scan of a part becomes.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct EstimateFigures {
    /// The number of surfaces of each kind, flat facets left out.
    pub surfaces: SurfaceCounts,
    /// The number of flat faces that are only facets.
    pub facets: usize,
    /// The radii of the cylinders, the widest first.
    pub radii_mm: Vec<f64>,
    /// The percentage of the area that they have.
    pub explained_pct: f64,
}

impl EstimateFigures {
    fn of(exact: &ExactEstimate) -> Self {
        let count = |kind| exact.kinds.iter().filter(|&&of| of == kind).count();
        EstimateFigures {
            surfaces: SurfaceCounts {
                plane: count(PrimitiveKind::Plane),
                cylinder: count(PrimitiveKind::Cylinder),
                cone: count(PrimitiveKind::Cone),
                sphere: count(PrimitiveKind::Sphere),
                torus: count(PrimitiveKind::Torus),
                ..SurfaceCounts::default()
            },
            facets: exact.facets,
            radii_mm: exact.radii.clone(),
            explained_pct: 100.0 * exact.explained,
        }
    }
}

/// One of several components of a scan.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PieceFigures {
    /// Triangles.
    pub triangles: usize,
    /// The extent in x, y and z.
    pub size_mm: [f64; 3],
    /// Boundary loops.
    pub loops: usize,
    /// The genus, as for the chosen component.
    #[cfg_attr(feature = "serde", serde(serialize_with = "serialize_genus"))]
    pub genus: f64,
}

impl PieceFigures {
    fn of(piece: &PieceReport) -> Self {
        let PieceReport { triangles, size, topology } = piece;
        let (loops, genus) = (topology.loops, topology.genus());
        PieceFigures { triangles: *triangles, size_mm: *size, loops, genus }
    }
}

/// A boundary loop of a scan.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RimFigures {
    /// Its length.
    pub length_mm: f64,
    /// Its vertices.
    pub vertices: usize,
    /// Whether it is the outer loop; the others are the rims of holes.
    pub outer: bool,
}

impl InspectionFigures {
    /// The figures of what [`inspect`](crate::convert::inspect) found.
    pub fn of(found: &Inspection, source: &ScanSource) -> Self {
        let rim = |(i, &(length_mm, vertices)): (usize, &(f64, usize))| RimFigures {
            length_mm,
            vertices,
            outer: found.outer == Some(i),
        };
        InspectionFigures {
            input: InputFigures::of(&found.input, source),
            genus: found.topology.genus(),
            orientable: found.topology.orientable,
            disk: found.topology.is_disk(),
            shape: found.shape.map(TargetShape::word),
            shape_reason: found.reason,
            tolerance_mm: found.tolerance,
            outline: found.is_ragged.map(|ragged| if ragged { "trimmed" } else { "sides" }),
            likely_units: likely_units(source, found.input.bounds)
                .iter()
                .map(|u| u.symbol())
                .collect(),
            pieces: found.pieces.iter().map(PieceFigures::of).collect(),
            faces_about: found.body.as_ref().map(|body| body.faces),
            exact: found.exact.as_ref().map(EstimateFigures::of),
            handles: found
                .body
                .iter()
                .flat_map(|body| &body.handles)
                .map(HandleFigures::of)
                .collect(),
            loops: found.loops.iter().enumerate().map(rim).collect(),
            left_out_triangles: found.input.left_out,
            noise_mm: found.noise,
        }
    }
}

/// A whole number without a decimal point, as the genus of a two-sided surface is.
#[cfg(feature = "serde")]
fn serialize_genus<S: serde::Serializer>(genus: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    if genus.fract() == 0.0 {
        serializer.serialize_i64(*genus as i64)
    } else {
        serializer.serialize_f64(*genus)
    }
}
