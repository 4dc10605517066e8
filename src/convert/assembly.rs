//! The parts of a scene, each converted once and placed as often as the scene has it.

use formats::assembly::AssemblyPart;
use formats::scene::{FormId, NodeId, SceneMesh};
use formats::{Assembly, Scene};
use rayon::prelude::*;

use super::{Conversion, Inspection, Options, convert, inspect, mesh_components};
use crate::error::Result;
use crate::mesh::{Choice, Outer};
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
}

/// Converts each form of a scene once, in its own frame, as [`convert`](convert()) does with one mesh, and places it as often
/// as the scene does. A part that cannot be converted is left out, and its error is in its place. `name` is that of the
/// whole, unless the scene has one root.
///
/// # Errors
/// The system starts no more threads.
pub fn convert_scene(scene: &Scene, options: &Options, name: &str) -> Result<AssemblyConversion> {
    // The frame of a part is that of the scene, so nothing may be taken off it.
    let inner = Options { threads: None, keeps_origin: true, ..options.clone() };
    let convert_part = |part: ScenePart| {
        let options = Options { name: part.name.clone(), ..inner.clone() };
        let made = convert(&scene.form_mesh(part.form).soup, &options, &mut |_| Ok(()));
        ConvertedPart { part, made }
    };
    let parts: Vec<ConvertedPart> =
        threads::run(options.threads, || parts(scene).into_par_iter().map(convert_part).collect())?;
    let mut by_form: Vec<Option<AssemblyPart>> = vec![None; scene.forms().len()];
    for ConvertedPart { part: ScenePart { form, colour, .. }, made } in &parts {
        let brep = made.iter().find_map(|made| Some(made.parts.first()?.brep.clone()));
        by_form[form.0] =
            brep.map(|brep| AssemblyPart { brep, colour: *colour, face_colours: Vec::new() });
    }
    let mm = options.unit_of(scene.unit);
    let assembly = Assembly::of_scene(scene, mm, by_form, name);
    Ok(AssemblyConversion { assembly, parts })
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

/// Looks at each form of a scene that has a place.
///
/// # Errors
/// The system starts no more threads.
pub fn inspect_scene(scene: &Scene, options: &Options) -> Result<Vec<InspectedPart>> {
    let inner = Options { threads: None, ..options.clone() };
    let look = |part: ScenePart| {
        let components = mesh_components(&scene.form_mesh(part.form).soup, &inner);
        let found = components.and_then(|of| inspect(of, Choice::Largest, Outer::Auto));
        InspectedPart { part, found }
    };
    threads::run(options.threads, || parts(scene).into_par_iter().map(look).collect())
}

/// The parts of a scene.
fn parts(scene: &Scene) -> Vec<ScenePart> {
    let part = |(number, (form, places)): (usize, (FormId, Vec<NodeId>))| {
        let mesh = &scene.meshes()[scene.forms()[form.0].mesh.0];
        let of_place = places.first().and_then(|&place| scene.name(place));
        let name = mesh.name.as_deref().or(of_place);
        let name = name.map_or_else(|| format!("part {number}"), str::to_owned);
        ScenePart { form, name, colour: mesh.colour.or(mesh.soup.colour), places }
    };
    scene.uses().into_iter().enumerate().map(part).collect()
}

/// Whether a scene has several places and its meshes are bodies of their own: all that are large enough to count are
/// closed. Nodes that are tiles of one sheet are not.
///
/// # Errors
/// The system starts no more threads.
pub fn has_parts(scene: &Scene, options: &Options) -> Result<bool> {
    if scene.place_count() < 2 {
        return Ok(false);
    }
    let uses = scene.uses();
    threads::run(options.threads, || {
        uses.par_iter().all(|(form, _)| is_closed(&scene.form_mesh(*form), options))
    })
}

/// Whether all components of a mesh that are large enough to count are closed.
fn is_closed(mesh: &SceneMesh, options: &Options) -> bool {
    let Ok(components) = mesh_components(&mesh.soup, options) else { return false };
    (0..components.sizeable()).all(|number| {
        components.take_whole(Choice::Number(number)).is_ok_and(|piece| piece.topology.loops == 0)
    })
}
