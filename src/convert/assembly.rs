//! The parts of a scene, each converted once and placed as often as the scene has it.

use std::ops::Range;

use formats::assembly::AssemblyPart;
use formats::scene::{FormId, NodeId, Placement};
use formats::{Assembly, Scene};
use rayon::prelude::*;

use super::{
    Conversion, Inspection, Memory, Options, PartColours, Stage, convert, inspect, measured,
    mesh_components,
};
use crate::error::{Error, Result};
use crate::geometry::Point;
use crate::mesh::{Choice, Components, Mesh, Outer};
use crate::stages::crop;
use crate::threads;

/// What became of the parts of a scene.
#[derive(Debug)]
#[non_exhaustive]
pub struct AssemblyConversion {
    /// What the writers take: the parts that were converted, in their places. `None` if there is none.
    pub assembly: Option<Assembly>,
    /// Each form of the scene that has a place, in the order of the forms.
    pub parts: Vec<ConvertedPart>,
}

/// A part of a scene: a form that has a place.
#[derive(Debug)]
#[non_exhaustive]
pub struct ScenePart {
    /// The form of the scene.
    pub form: FormId,
    /// The name of the product: that of the mesh, or else of its first place, or else its number.
    pub name: String,
    /// The colour of the part (sRGB).
    pub colour: Option<[u8; 3]>,
    /// The nodes that place it.
    pub places: Vec<NodeId>,
}

/// A part, and what became of it.
#[derive(Debug)]
#[non_exhaustive]
pub struct ConvertedPart {
    /// The part.
    pub part: ScenePart,
    /// What became of it, or why nothing did. Lengths are mm in the part's own frame.
    pub made: Result<Conversion>,
    /// The colours of it and of its faces.
    pub colours: PartColours,
}

/// The parts of a scene as meshes.
#[derive(Debug)]
pub struct SceneParts {
    scene: Scene,
    parts: Vec<(ScenePart, Result<Components>)>,
}

impl SceneParts {
    /// The parts of a scene. What the options leave out of a scan is not left out here ([`cropped`]).
    ///
    /// # Errors
    /// The system starts no more threads.
    pub fn of(scene: Scene, options: &Options) -> Result<Self> {
        let options = of_parts(options);
        let components = |part: ScenePart| {
            let components = mesh_components(&scene.form_mesh(part.form).soup, &options);
            (part, components)
        };
        let all = threads::run(options.threads, || {
            scene_parts(&scene).into_par_iter().map(components).collect()
        });
        Ok(SceneParts { parts: all?, scene })
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene again.
    pub fn into_scene(self) -> Scene {
        self.scene
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.parts.len()
    }

    /// Whether the scene has several places and its meshes are bodies of their own: all that are large enough to count
    /// are closed. Nodes that are tiles of one sheet are not.
    ///
    /// # Errors
    /// The system starts no more threads.
    pub fn are_bodies(&self, options: &Options) -> Result<bool> {
        if self.scene.place_count() < 2 {
            return Ok(false);
        }
        let is_closed = |(_, components): &(ScenePart, Result<Components>)| {
            let Ok(components) = components else { return false };
            (0..components.sizeable()).all(|number| {
                let piece = components.take_whole(Choice::Number(number));
                piece.is_ok_and(|piece| piece.topology.loops == 0)
            })
        };
        threads::run(options.threads, || self.parts.par_iter().all(is_closed))
    }

    /// The points and triangles of all components in all places, as they were measured. Lengths are mm.
    ///
    /// # Errors
    /// A part has no mesh, or the system starts no more threads.
    pub fn measured(self, options: &Options) -> Result<MeasuredScene> {
        let SceneParts { scene, parts } = self;
        let mm = options.unit_of(scene.unit);
        let (frames, mut mesh) =
            (scene.places(), Mesh { points: Vec::new(), triangles: Vec::new() });
        let (mut places, mut components, mut names) = (Vec::new(), 0, Vec::new());
        for (number, (part, of_part)) in parts.into_iter().enumerate() {
            let of_part = of_part?;
            let all = of_part.all(Outer::Auto);
            components += all.len() * part.places.len();
            let origin = of_part.origin();
            let own = measured(&of_part, &all, Outer::Auto)?.translated(origin).mesh;
            for &node in &part.places {
                let Placement { axes, translation } = frames[node.0];
                let place = Placement { axes, translation: translation.map(|x| mm * x) };
                let first = mesh.points.len();
                let point = |p: &Point| Point::from(place.apply((*p).into()));
                mesh.append(&Mesh {
                    points: own.points.iter().map(point).collect(),
                    triangles: own.triangles.clone(),
                });
                places.push(MeasuredPlace { node, part: number, points: first..mesh.points.len() });
            }
            names.push(part);
        }
        Ok(MeasuredScene { scene, mesh, places, parts: names, components })
    }

    /// Looks at each part.
    ///
    /// # Errors
    /// The system starts no more threads.
    pub fn inspect(self, options: &Options) -> Result<(Scene, Vec<InspectedPart>)> {
        let look = |(part, components): (ScenePart, Result<Components>)| {
            let found = components.and_then(|of| inspect(of, Choice::Largest, Outer::Auto));
            InspectedPart { part, found }
        };
        let found =
            threads::run(options.threads, || self.parts.into_par_iter().map(look).collect());
        Ok((self.scene, found?))
    }
}

/// All parts of a scene in their places, as they were measured.
#[derive(Debug)]
#[non_exhaustive]
pub struct MeasuredScene {
    /// The scene.
    pub scene: Scene,
    /// Its parts.
    pub parts: Vec<ScenePart>,
    /// All components in all places, in mm.
    pub mesh: Mesh,
    /// The places of all parts, one part after the other.
    pub places: Vec<MeasuredPlace>,
    /// The number of the components in all places.
    pub components: usize,
}

/// A part in one of its places.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct MeasuredPlace {
    /// The node that places it.
    pub node: NodeId,
    /// The number of the part.
    pub part: usize,
    /// Its points in the mesh of the scene.
    pub points: Range<usize>,
}

/// A callback that sees each [`Stage`] of each part, by its number. It is called on several threads at once. An error of
/// its own stops the part.
pub type PartObserver<'a> = dyn Fn(usize, Stage) -> Result<()> + Sync + 'a;

/// The options of a part. Its frame is that of the scene, so nothing may be taken off it, and what is left out of the
/// scan was left out of the scene.
fn of_parts(options: &Options) -> Options {
    let mut inner = Options { keeps_origin: true, max_memory: None, ..options.clone() };
    inner.cloud.crop = crop::Options::default();
    inner
}

/// Converts each part of a scene once, in its own frame, as [`convert`](convert()) does with one mesh, and places it as often
/// as the scene does. A part that cannot be converted is left out, and its error is in its place. `name` is that of the
/// whole, unless the scene has one root. The scene comes back.
///
/// # Errors
/// [`Error::Unaligned`] if the parts are to be aligned, [`Error::Stopped`] if `watch` stopped a part, [`Error::MaxMemory`] if the parts may need more memory than the options
/// allow, or the system starts no more threads.
pub fn convert_scene(
    parts: SceneParts,
    options: &Options,
    name: &str,
    watch: &PartObserver,
) -> Result<(Scene, AssemblyConversion)> {
    let SceneParts { scene, parts } = parts;
    if options.align {
        return Err(Error::Unaligned("several parts keep their places to each other".into()));
    }
    if let Some(most) = options.max_memory {
        Memory::of_scene(&scene, options).check(most)?;
    }
    let inner = Options { threads: None, ..of_parts(options) };
    let convert_part = |(number, (part, components)): (usize, (ScenePart, Result<Components>))| {
        let options = Options { name: part.name.clone(), ..inner.clone() };
        let mut watch = |stage: Stage| watch(number, stage);
        let made = match (options.remesh, components) {
            (true, _) => convert(&scene.form_mesh(part.form).soup, &options, &mut watch),
            (false, Err(error)) => Err(error),
            (false, Ok(components)) => convert(&components, &options, &mut watch),
        };
        (part, made)
    };
    let made: Vec<(ScenePart, Result<Conversion>)> = threads::run(options.threads, || {
        parts.into_par_iter().enumerate().map(convert_part).collect()
    })?;
    if made.iter().any(|(_, made)| matches!(made, Err(Error::Stopped))) {
        return Err(Error::Stopped);
    }
    let mm = options.unit_of(scene.unit);
    let mut by_form: Vec<Option<AssemblyPart>> = vec![None; scene.forms().len()];
    let mut parts = Vec::with_capacity(made.len());
    for (mut part, made) in made {
        let mut colours = PartColours { part: part.colour, ..PartColours::default() };
        if let Some(of) = made.iter().find_map(|made| made.parts.first()) {
            colours = PartColours::of(&scene.form_mesh(part.form), mm, of);
            part.colour = colours.part;
            by_form[part.form.0] = Some(AssemblyPart {
                brep: of.brep.clone(),
                colour: colours.part,
                face_colours: colours.faces.clone(),
            });
        }
        parts.push(ConvertedPart { part, made, colours });
    }
    let assembly = Assembly::of_scene(&scene, mm, by_form, name);
    Ok((scene, AssemblyConversion { assembly, parts }))
}

/// A part, and what it is.
#[derive(Debug)]
#[non_exhaustive]
pub struct InspectedPart {
    /// The part.
    pub part: ScenePart,
    /// What it is, and what it would become. Lengths are mm in the part's own frame.
    pub found: Result<Inspection>,
}

/// The parts of a scene.
fn scene_parts(scene: &Scene) -> Vec<ScenePart> {
    let part = |(number, (form, places)): (usize, (FormId, Vec<NodeId>))| {
        let mesh = &scene.meshes()[scene.forms()[form.0].mesh.0];
        let of_place = places.first().and_then(|&place| scene.name(place));
        let name = mesh.name.as_deref().or(of_place);
        let name = name.map_or_else(|| format!("part {number}"), str::to_owned);
        ScenePart { form, name, colour: mesh.colour.or(mesh.soup.colour), places }
    };
    scene.uses().into_iter().enumerate().map(part).collect()
}

/// The scene without what the options leave out of a scan. A part that is cut becomes one of its own.
///
/// # Errors
/// Those of [`crop::kept`](crate::stages::crop::kept), or the scene repeats its meshes too often.
pub fn cropped(scene: Scene, options: &Options) -> Result<Scene> {
    if options.cloud.crop.keeps_all() {
        return Ok(scene);
    }
    let points = scene.placed_points().map_err(Error::File)?;
    let kept = crop::kept(&points, [0.0; 3], &options.cloud.crop)?;
    Ok(scene.without_points(&kept))
}
