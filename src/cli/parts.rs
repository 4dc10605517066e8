//! `--parts`: what is converted of a file with several parts.

use formats::scene::{NodeContent, NodeId};
use formats::{Scene, SceneContent};

use scan2step::SceneParts;

use super::args::{ComponentChoice, Convert, PartsChoice};
use super::input::{self, ReadScan};
use super::places::NamedCorners;
use super::progress::ProgressDisplay;
use super::{Failure, assembly};

/// What is converted of a file.
pub(crate) enum Chosen {
    /// A cloud, or all meshes as one.
    One(SceneContent),
    /// Each part of its own.
    Assembly(SceneParts),
}

/// What the user chose, or what suits the file.
pub(crate) fn chosen(
    args: &Convert,
    content: SceneContent,
    progress: &ProgressDisplay,
) -> Result<Chosen, Failure> {
    let SceneContent::Scene(scene) = content else { return Ok(Chosen::One(content)) };
    let one = |scene| Ok(Chosen::One(SceneContent::Scene(scene)));
    if args.how.parts == Some(PartsChoice::Merge) {
        return one(scene);
    }
    let split = scene.split_groups();
    let parts = split.as_ref().unwrap_or(&scene);
    match &args.how.parts {
        Some(PartsChoice::Number(number)) => {
            let used = parts.uses();
            let Some(&(form, _)) = used.get(*number) else {
                let error = format!("{}: has no part {number}", args.piece.scan.name.display());
                let help = format!("name a part from 0 to {}", used.len().saturating_sub(1));
                return Err(Failure { error, help });
            };
            one(parts.form_alone(form))
        }
        Some(PartsChoice::Name(name)) => named(args, parts, name),
        Some(PartsChoice::Keep) if parts.place_count() > 1 => match hindrance(args) {
            None => kept(args, split.unwrap_or(scene)),
            Some(why) => Err(Failure {
                error: format!("--parts keep: {why}"),
                help: "leave it out, or convert one mesh with --parts merge".into(),
            }),
        },
        Some(_) => one(scene),
        None => by_itself(args, scene, split, progress),
    }
}

/// An assembly, whatever its meshes are.
fn kept(args: &Convert, scene: Scene) -> Result<Chosen, Failure> {
    let options = ReadScan::options(&args.piece)?;
    let parts = assembly::parts_of(scene, &options, true);
    match parts.map_err(|e| input::stopped(&args.piece.scan.name, &e))? {
        Ok(parts) => Ok(Chosen::Assembly(parts)),
        Err(scene) => Ok(Chosen::One(SceneContent::Scene(scene))),
    }
}

/// An assembly where all meshes are closed and nothing that was asked for needs one mesh.
fn by_itself(
    args: &Convert,
    scene: Scene,
    split: Option<Scene>,
    progress: &ProgressDisplay,
) -> Result<Chosen, Failure> {
    let count = split.as_ref().unwrap_or(&scene).place_count();
    if count < 2 {
        return Ok(Chosen::One(SceneContent::Scene(scene)));
    }
    let options = ReadScan::options(&args.piece)?;
    let (scene, why) = match hindrance(args) {
        Some(why) => (scene, why),
        None => {
            let (whole, scene) = match split {
                Some(split) => (Some(scene), split),
                None => (None, scene),
            };
            let parts = assembly::parts_of(scene, &options, false);
            match parts.map_err(|e| input::stopped(&args.piece.scan.name, &e))? {
                Ok(parts) => {
                    let why = "as all of its meshes are closed (--parts to change)";
                    progress.say(&format!("parts: kept, {why}"));
                    return Ok(Chosen::Assembly(parts));
                }
                Err(scene) => (whole.unwrap_or(scene), "not all of its meshes are closed"),
            }
        }
    };
    progress.say(&format!("parts: all as one mesh, as {why} (--parts to change)"));
    Ok(Chosen::One(SceneContent::Scene(scene)))
}

/// Why an assembly cannot be written with what was asked for.
fn hindrance(args: &Convert) -> Option<&'static str> {
    if args.piece.cloud.remesh {
        return Some("--remesh takes the points of all meshes together");
    }
    let names_place = args.piece.outer.is_some()
        || args.corners.is_some()
        || matches!(args.how.boundary_corners, NamedCorners::At(_))
        || matches!(args.how.component, ComponentChoice::Number(_));
    names_place.then_some("a place or a component of one mesh is named")
}

/// The places that a name means: a place, a group, a product, or a path of names.
fn named(args: &Convert, scene: &Scene, name: &str) -> Result<Chosen, Failure> {
    let is_named = |node: NodeId| {
        let of = &scene.nodes()[node.0];
        let product = match of.content {
            NodeContent::Group => of.group_name.as_deref(),
            NodeContent::Form(form) => scene.meshes()[scene.forms()[form.0].mesh.0].name.as_deref(),
        };
        of.name.as_deref() == Some(name)
            || product == Some(name)
            || scene.path(node).join(" / ") == name
    };
    let kept = scene.clone().kept(is_named);
    match (kept.place_count(), hindrance(args)) {
        (0, _) => Err(Failure {
            error: format!(
                "{}: has no part called \u{201c}{name}\u{201d}",
                args.piece.scan.name.display()
            ),
            help: "scan2step inspect lists the parts".into(),
        }),
        (1, _) | (_, Some(_)) => Ok(Chosen::One(SceneContent::Scene(kept))),
        (_, None) => self::kept(args, kept),
    }
}
