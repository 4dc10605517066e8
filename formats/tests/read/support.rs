//! Files to read, and their expected results.

use std::fs;
use std::path::{Path, PathBuf};

use formats::scene::{FormId, NodeContent, NodeId, SceneNode};
use formats::{Error, Result, Scene, Soup, read_scan, read_scene};
use tempfile::TempDir;

pub use crate::seeds::gzip;

/// A folder with one file.
pub struct Case {
    _folder: TempDir,
    pub path: PathBuf,
}

pub fn case(name: &str, content: impl AsRef<[u8]>) -> Case {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let path = folder.path().join(name);
    fs::write(&path, content).expect("a file for the test");
    Case { _folder: folder, path }
}

pub fn read(name: &str, content: impl AsRef<[u8]>) -> Result<Soup> {
    read_scan(&case(name, content).path)
}

/// The soup of a file that must be readable.
#[track_caller]
pub fn soup(name: &str, content: impl AsRef<[u8]>) -> Soup {
    read(name, content).unwrap_or_else(|e| panic!("{e}"))
}

/// The error of a file that must be refused. It has help and mentions `word`.
#[track_caller]
pub fn refusal(name: &str, content: impl AsRef<[u8]>, word: &str) -> Error {
    refused(read(name, content), word)
}

#[track_caller]
pub fn refused(result: Result<Soup>, word: &str) -> Error {
    let error = result.expect_err("should be refused");
    assert!(error.help.ends_with('.'), "no help in: {error}");
    assert!(error.to_string().contains(word), "no {word:?} in: {error}");
    error
}

pub fn polygons(soup: &Soup) -> Vec<Vec<u32>> {
    soup.polygons.iter().map(<[u32]>::to_vec).collect()
}

/// The triangles after each polygon is divided into a fan.
pub fn triangles(soup: &Soup) -> usize {
    soup.polygons.iter().map(|p| p.len() - 2).sum()
}

/// The folder of collected scans, if it is beside this checkout.
pub fn scans() -> Option<PathBuf> {
    let folder = shared("scans");
    folder.join("INDEX.tsv").is_file().then_some(folder)
}

/// The scene of a file that must be readable.
#[track_caller]
pub fn scene(name: &str, content: impl AsRef<[u8]>) -> Scene {
    read_scene(&case(name, content).path).unwrap_or_else(|e| panic!("{e}"))
}

/// One line for each node of a scene: its level, its name, and the name, the colour and the triangles of its mesh.
pub fn tree(scene: &Scene) -> Vec<String> {
    let mut levels = Vec::new();
    let line = |node: &SceneNode| {
        let level = node.parent.map_or(0, |NodeId(parent)| levels[parent] + 1);
        levels.push(level);
        let name = node.name.as_deref().unwrap_or("-");
        let what = match node.content {
            NodeContent::Group => format!("group {}", node.group_name.as_deref().unwrap_or("-")),
            NodeContent::Form(FormId(form)) => {
                let form = &scene.forms()[form];
                let mesh = &scene.meshes()[form.mesh.0];
                let product = mesh.name.as_deref().unwrap_or("-");
                let stretched = if form.stretch.is_some() { " stretched" } else { "" };
                format!("{product} {:?} {}{stretched}", mesh.colour, mesh.soup.polygons.len())
            }
        };
        format!("{level} {name}: {what}")
    };
    scene.nodes().iter().map(line).collect()
}

/// The folder of collected assemblies, if it is beside this checkout.
pub fn assemblies() -> Option<PathBuf> {
    let folder = shared("assemblies");
    folder.join("README.txt").is_file().then_some(folder)
}

/// A folder beside this checkout, which need not be there.
fn shared(name: &str) -> PathBuf {
    // Cargo says where the crate is when it runs a test, too.
    let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or(env!("CARGO_MANIFEST_DIR").into());
    Path::new(&root).join("../../shared").join(name)
}
