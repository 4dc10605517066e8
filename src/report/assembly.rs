//! The report of an assembly: what each part became, and where it is placed.

use formats::Scene;
use formats::scene::{NodeId, Placement};

#[cfg(feature = "serde")]
use super::serialize_parts;
use super::{BodyFigures, InspectionFigures, OutputFile, ScanSource, Settings, VERSION};
use crate::convert::{AssemblyConversion, ConvertedPart, InspectedPart, Options, ScenePart};
use crate::words::plural;

/// What became of a file with several parts.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct AssemblyReport {
    /// The version of this library.
    pub scan2step: &'static str,
    /// The file.
    pub input: AssemblySource,
    /// The parts, in the order in which the file places them first.
    pub parts: Vec<PartFigures>,
    /// What the caller asked for; `options` in the JSON.
    #[cfg_attr(feature = "serde", serde(rename = "options"))]
    pub settings: Settings,
    /// What could be better, and what to do about it: one sentence each, after the name of the part.
    pub hints: Vec<String>,
    /// The words of a command line that makes the same files. The caller fills it in.
    pub command: Vec<String>,
    /// The files that were written. The caller fills it in.
    pub outputs: Vec<OutputFile>,
    /// Seconds since the run began. The caller fills it in.
    pub seconds: f64,
    /// The largest resident memory of the process, in MB (10⁶ bytes). The caller fills it in.
    pub peak_rss_mb: f64,
}

/// A file with several parts.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct AssemblySource {
    /// The file as the caller named it.
    pub file: String,
    /// The symbol of the unit of its numbers.
    pub units: &'static str,
    /// Whether neither the file nor the caller names the unit.
    pub units_assumed: bool,
    /// Vertices of the meshes, each once.
    pub file_vertices: usize,
    /// Triangles of the meshes, each once.
    pub file_triangles: usize,
    /// What the user should know about how the file was read.
    pub notes: Vec<String>,
}

/// A part and its places.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PartFigures {
    /// The name of the product.
    pub name: String,
    /// The colour (sRGB), if the part has one.
    pub colour: Option<[u8; 3]>,
    /// The number of faces with another colour.
    pub coloured_faces: usize,
    /// Where it is.
    pub places: Vec<PlaceFigures>,
    /// Why the part could not be converted.
    pub error: Option<String>,
    /// The figures of each body. In the JSON those of the first stand beside the other fields, and all are in
    /// `components` if there are several.
    #[cfg_attr(feature = "serde", serde(flatten, serialize_with = "serialize_parts"))]
    pub bodies: Vec<BodyFigures>,
}

/// A place of a part.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct PlaceFigures {
    /// The names of the groups around it, and its own.
    pub path: Vec<String>,
    /// The rows of the map from the part to the whole, in mm: a rotation and a translation.
    pub matrix: [[f64; 4]; 3],
    /// The colour of this place (sRGB), if it is another one than that of the part.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
    pub colour: Option<[u8; 3]>,
}

impl AssemblyReport {
    /// The report of an assembly. The command, outputs, seconds and memory are empty or 0 until the caller fills them in.
    pub fn of(
        scene: &Scene,
        made: &AssemblyConversion,
        (file, options): (&str, &Options),
        settings: Settings,
    ) -> Self {
        let mm = options.unit_of(scene.unit);
        let outliers = settings.outliers / 100.0;
        let places = ScenePlaces::of(scene, mm);
        let figures = |part: &ConvertedPart| {
            let ScenePart { form, name, colour, places: nodes } = &part.part;
            let source = ScanSource::of(file, &scene.form_mesh(*form).soup, options);
            let bodies = part.made.iter().flat_map(|made| made.bodies());
            PartFigures {
                name: name.clone(),
                colour: *colour,
                coloured_faces: part.colours.faces.len(),
                places: places.figures(nodes),
                error: part.made.as_ref().err().map(ToString::to_string),
                bodies: bodies.map(|body| BodyFigures::of(body, &source, outliers)).collect(),
            }
        };
        let hints = made.parts.iter().flat_map(|part| {
            let bodies = part.made.iter().flat_map(|made| made.bodies());
            let of_bodies = bodies.flat_map(|body| body.hints.iter().cloned());
            let mixed = part.colours.mixed;
            let of_colours = (mixed > 0).then(|| {
                format!(
                    "{} of several colours gets that of most of its area",
                    plural(mixed, "face")
                )
            });
            let hints = of_bodies.chain(of_colours);
            hints.map(|hint| format!("{}: {hint}", part.part.name)).collect::<Vec<_>>()
        });
        AssemblyReport {
            scan2step: VERSION,
            input: AssemblySource::of(scene, file, options),
            parts: made.parts.iter().map(figures).collect(),
            hints: hints.collect(),
            settings,
            command: Vec::new(),
            outputs: Vec::new(),
            seconds: 0.0,
            peak_rss_mb: 0.0,
        }
    }
}

impl AssemblySource {
    /// The file of a scene, with the unit that a conversion with these options takes.
    pub fn of(scene: &Scene, file: &str, options: &Options) -> Self {
        let declared = options.unit().or(scene.unit);
        let meshes = || scene.meshes().iter().map(|mesh| &mesh.soup);
        let stretched = match scene.stretched_count() {
            0 => None,
            count => {
                let parts = plural(count, "part");
                Some(format!(
                    "{parts} scaled or mirrored in the file: CAD files place parts by motions, so each is its own"
                ))
            }
        };
        AssemblySource {
            file: file.to_owned(),
            units: declared.unwrap_or(formats::LengthUnit::Millimetre).symbol(),
            units_assumed: declared.is_none(),
            file_vertices: meshes().map(|soup| soup.points.len()).sum(),
            file_triangles: meshes().map(|soup| soup.polygons.triangle_count()).sum(),
            notes: scene.notes.iter().map(ToString::to_string).chain(stretched).collect(),
        }
    }
}

/// What a file with several parts is.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct AssemblyInspection {
    /// The file. Its fields stand beside the others in the JSON.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub input: AssemblySource,
    /// The parts, in the order in which the file places them first.
    pub parts: Vec<InspectedPartFigures>,
}

/// What a part is, and its places.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[non_exhaustive]
pub struct InspectedPartFigures {
    /// The name of the product.
    pub name: String,
    /// The colour (sRGB), if the part has one.
    pub colour: Option<[u8; 3]>,
    /// Where it is.
    pub places: Vec<PlaceFigures>,
    /// Why nothing is known of the part.
    pub error: Option<String>,
    /// What it is. The fields stand beside the others in the JSON.
    #[cfg_attr(feature = "serde", serde(flatten))]
    pub found: Option<InspectionFigures>,
}

impl AssemblyInspection {
    /// The figures of the parts of a scene.
    pub fn of(scene: &Scene, parts: &[InspectedPart], file: &str, options: &Options) -> Self {
        let places = ScenePlaces::of(scene, options.unit_of(scene.unit));
        let figures = |part: &InspectedPart| {
            let ScenePart { form, name, colour, places: nodes } = &part.part;
            let source = ScanSource::of(file, &scene.form_mesh(*form).soup, options);
            let found = part.found.as_ref();
            InspectedPartFigures {
                name: name.clone(),
                colour: *colour,
                places: places.figures(nodes),
                error: found.err().map(ToString::to_string),
                found: found.ok().map(|found| InspectionFigures::of(found, &source)),
            }
        };
        AssemblyInspection {
            input: AssemblySource::of(scene, file, options),
            parts: parts.iter().map(figures).collect(),
        }
    }
}

/// The places of all nodes of a scene.
struct ScenePlaces<'a> {
    scene: &'a Scene,
    places: Vec<Placement>,
    mm: f64,
}

impl<'a> ScenePlaces<'a> {
    fn of(scene: &'a Scene, mm: f64) -> Self {
        ScenePlaces { scene, places: scene.places(), mm }
    }

    fn figures(&self, nodes: &[NodeId]) -> Vec<PlaceFigures> {
        let place = |node: &NodeId| PlaceFigures {
            path: self.scene.path(*node).into_iter().map(str::to_owned).collect(),
            matrix: matrix(&self.places[node.0], self.mm),
            colour: self.scene.nodes()[node.0].colour,
        };
        nodes.iter().map(place).collect()
    }
}

/// The rows of a map in mm, if its lengths have so many `mm`.
fn matrix(placement: &Placement, mm: f64) -> [[f64; 4]; 3] {
    let [x, y, z] = placement.axes;
    [0, 1, 2].map(|row| [x[row], y[row], z[row], mm * placement.translation[row]])
}
