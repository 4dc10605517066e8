//! Preparation of the JSON for the gltf crate.
//!
//! The crate requires elements that the specification does not require: the list of nodes of a
//! scene, the node of an animation, the image of a texture. A mesh needs none of these, so they are
//! removed. The remaining text stays at the same lines, because errors name them.

use std::ops::Range;

use ::gltf::json::{self, Root, deserialize};
use serde::Deserialize;
use serde_json::value::RawValue;

use super::extras::Extras;
use super::glb::is_glb;
use super::wrong_version;
use crate::source::{EXPORT_AGAIN, Source};
use crate::{Error, Result};

/// The largest number of JSON objects. An object takes at least two bytes in the file (`{}`), and a
/// node takes 300 bytes in memory.
pub(super) const MOST_OBJECTS: usize = 1 << 17;

/// The root nodes of each scene.
pub(super) type Scenes = Vec<Vec<u64>>;

/// The parts of the JSON that this module examines. They are not copied.
#[derive(Deserialize)]
pub(super) struct JsonParts<'a> {
    #[serde(borrow)]
    asset: Option<&'a RawValue>,
    scenes: Option<&'a RawValue>,
    pub(super) nodes: Option<&'a RawValue>,
    pub(super) meshes: Option<&'a RawValue>,
    #[serde(rename = "bufferViews")]
    pub(super) buffer_views: Option<&'a RawValue>,
    accessors: Option<&'a RawValue>,
    animations: Option<&'a RawValue>,
    cameras: Option<&'a RawValue>,
    images: Option<&'a RawValue>,
    pub(super) materials: Option<&'a RawValue>,
    samplers: Option<&'a RawValue>,
    skins: Option<&'a RawValue>,
    textures: Option<&'a RawValue>,
}

#[derive(Deserialize)]
struct Asset {
    version: String,
}

#[derive(Deserialize)]
struct JsonScene {
    #[serde(default)]
    nodes: Vec<u64>,
}

/// Parses `text`. The scenes are returned separately and are not in the root.
pub(super) fn parse(source: &Source, mut text: Vec<u8>) -> Result<(Root, Scenes, Extras)> {
    if text.starts_with(b"\xef\xbb\xbf") {
        text[..3].fill(b' ');
    }
    if !is_glb(&source.head) && text.trim_ascii_start().first() != Some(&b'{') {
        let what = "it begins neither with \u{201c}glTF\u{201d}, as a GLB file does, nor with \
                    \u{201c}{\u{201d}";
        return Err(unsound(source, what));
    }
    let (scenes, extras) = prepare(source, &mut text)?;
    if objects(&text) > MOST_OBJECTS {
        let what = format!("has a scene of more than {MOST_OBJECTS} objects");
        return Err(source.error(what, "Export the scan alone, as one mesh."));
    }
    let root: Root = deserialize::from_slice(&text).map_err(|e| unsound(source, e))?;
    check_version(source, &root.asset.version)?;
    let scenes = scenes.unwrap_or_else(|| {
        let nodes = |scene: &json::Scene| scene.nodes.iter().map(|n| n.value() as u64).collect();
        root.scenes.iter().map(nodes).collect()
    });
    Ok((root, scenes, extras))
}

/// An upper bound on the number of objects. A brace in a name counts, too, which does no harm.
pub(super) fn objects(text: &[u8]) -> usize {
    text.iter().filter(|&&byte| byte == b'{').count()
}

/// Removes the parts that the crate does not need. `None` if the JSON cannot be parsed. Then the
/// crate reports the error.
fn prepare(source: &Source, text: &mut [u8]) -> Result<(Option<Scenes>, Extras)> {
    let Ok(parts) = serde_json::from_slice::<JsonParts>(text) else {
        return Ok((None, Extras::default()));
    };
    check_asset(source, &parts)?;
    let lists = [parts.nodes, parts.meshes, parts.buffer_views];
    let count = |list: &RawValue| objects(list.get().as_bytes());
    let extras = match lists.into_iter().flatten().map(count).sum::<usize>() <= MOST_OBJECTS {
        true => Extras::read(&parts).map_err(|e| unsound(source, e))?,
        // The caller refuses so many.
        false => Extras::default(),
    };
    let scenes = parts.scenes.map_or(Some(Vec::new()), read_scenes);
    let unneeded = [
        parts.animations,
        parts.cameras,
        parts.images,
        parts.materials,
        parts.samplers,
        parts.skins,
        parts.textures,
        parts.scenes.filter(|_| scenes.is_some()),
    ];
    let spans = unneeded.map(|part| part.map(|part| span(text, part)));
    for span in spans.into_iter().flatten() {
        empty(&mut text[span]);
    }
    Ok((scenes, extras))
}

fn read_scenes(part: &RawValue) -> Option<Scenes> {
    if objects(part.get().as_bytes()) > MOST_OBJECTS {
        return None;
    }
    let scenes: Vec<JsonScene> = serde_json::from_str(part.get()).ok()?;
    Some(scenes.into_iter().map(|scene| scene.nodes).collect())
}

/// The range of `part`, which must be a slice of `text`.
fn span(text: &[u8], part: &RawValue) -> Range<usize> {
    let start = part.get().as_ptr().addr() - text.as_ptr().addr();
    start..start + part.get().len()
}

/// Replaces an array by an empty one with the same number of lines.
fn empty(array: &mut [u8]) {
    if let [b'[', inner @ .., b']'] = array {
        inner.iter_mut().filter(|b| !matches!(b, b'\r' | b'\n')).for_each(|b| *b = b' ');
    }
}

/// Checks the version before the crate reports other differences from version 2.0.
fn check_asset(source: &Source, parts: &JsonParts) -> Result<()> {
    let asset = parts.asset.and_then(|asset| serde_json::from_str::<Asset>(asset.get()).ok());
    if let Some(asset) = asset {
        return check_version(source, &asset.version);
    }
    // Version 1 had objects instead of arrays, and such a file need not declare its version.
    let lists = [parts.nodes, parts.meshes, parts.accessors, parts.scenes];
    if lists.into_iter().flatten().any(|list| list.get().starts_with('{')) {
        return check_version(source, "1.0");
    }
    Ok(())
}

fn check_version(source: &Source, version: &str) -> Result<()> {
    if version.starts_with("2.") { Ok(()) } else { Err(wrong_version(source, version)) }
}

fn unsound(source: &Source, why: impl std::fmt::Display) -> Error {
    source.error(format!("is not a valid glTF 2.0 file: {why}"), EXPORT_AGAIN)
}
