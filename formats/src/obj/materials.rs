//! The colours of an OBJ file: those of the materials that its faces use.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

use crate::colour::srgb;
use crate::scene::{ColourRuns, SceneMesh, SceneNote};
use crate::token::{excerpt, plain_number};

/// The most materials of a file. More colours are those of a texture.
const MOST_MATERIALS: usize = 10_000;

/// The most files of materials, and the size in bytes of which each is read. A material takes some hundred bytes.
const MOST_LIBRARIES: usize = 64;
const MOST_BYTES: u64 = 4 << 20;

/// The materials of faces while they are read.
#[derive(Default)]
pub(super) struct Materials {
    /// The number of each material by its name.
    numbers: BTreeMap<Vec<u8>, usize>,
    /// The number of the face after the last one with a material, and the number of this material.
    runs: Vec<(usize, Option<usize>)>,
    current: Option<usize>,
    libraries: Vec<String>,
}

impl Materials {
    /// The faces after the first `end` ones have the material `name`.
    pub(super) fn begin(&mut self, name: &[u8], end: usize) {
        self.end_run(end);
        let (name, next) = (name.trim_ascii(), self.numbers.len());
        self.current = match self.numbers.get(name) {
            Some(&known) => Some(known),
            None if next < MOST_MATERIALS => {
                self.numbers.insert(name.to_owned(), next);
                Some(next)
            }
            None => None,
        };
    }

    fn end_run(&mut self, end: usize) {
        match self.runs.last_mut() {
            Some(last) if last.1 == self.current => last.0 = end,
            Some(last) if last.0 == end => {}
            _ => self.runs.push((end, self.current)),
        }
    }

    pub(super) fn add_library(&mut self, names: &[u8]) {
        if self.libraries.len() < MOST_LIBRARIES {
            self.libraries.push(String::from_utf8_lossy(names.trim_ascii()).into_owned());
        }
    }

    /// Gives the `count` faces of the mesh their colours. Returns why there are none although there are materials.
    pub(super) fn give(
        mut self,
        folder: Option<&Path>,
        count: usize,
        mesh: &mut SceneMesh,
    ) -> Option<SceneNote> {
        self.end_run(count);
        if self.numbers.is_empty() || self.libraries.is_empty() {
            return None;
        }
        let mut colours = vec![None; self.numbers.len()];
        let mut missing = None;
        for library in &self.libraries {
            match folder.map(|folder| read_library(folder, library)) {
                Some(Ok(text)) => self.read_colours(&text, &mut colours),
                Some(Err(e)) => {
                    let name = excerpt(library.as_bytes());
                    missing = Some(format!("the materials in {name} cannot be read ({e})"));
                }
                None => missing = Some("its materials are in another file".to_owned()),
            }
        }
        let mut runs = ColourRuns::default();
        for (end, material) in self.runs {
            runs.extend_to(end, material.and_then(|material| colours[material]));
        }
        runs.give(mesh);
        missing.map(SceneNote::NoMaterials)
    }

    /// Reads the diffuse colours (`Kd`) of the materials that faces use. A texture takes the place of the colour.
    fn read_colours(&self, text: &[u8], colours: &mut [Option<[u8; 3]>]) {
        let mut current = None;
        for line in text.split(|b| matches!(b, b'\r' | b'\n')) {
            let line = line.trim_ascii();
            let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
            let (word, rest) = line.split_at(end);
            match word.to_ascii_lowercase().as_slice() {
                b"newmtl" => current = self.numbers.get(rest.trim_ascii()).copied(),
                b"kd" => {
                    if let Some(material) = current {
                        colours[material] = colour(rest);
                    }
                }
                b"map_kd" => {
                    if let Some(material) = current.take() {
                        colours[material] = None;
                    }
                }
                _ => {}
            }
        }
    }
}

/// The colour of `Kd r g b`. Programs write what they show, which is sRGB.
fn colour(text: &[u8]) -> Option<[u8; 3]> {
    let text = std::str::from_utf8(text).ok()?;
    let numbers: Vec<f64> =
        text.split_ascii_whitespace().map_while(|word| plain_number(word).parse().ok()).collect();
    match numbers[..] {
        // One number is a grey.
        [grey] => srgb([grey; 3]),
        [r, g, b, ..] => srgb([r, g, b]),
        _ => None,
    }
}

/// Reads a file of materials. It must be beside the scan: only the name after the last separator counts.
fn read_library(folder: &Path, path: &str) -> io::Result<Vec<u8>> {
    let name = path.rsplit(['/', '\\']).next().unwrap_or_default();
    if name.is_empty() || name == ".." || name.contains(['\0', ':']) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it has no name"));
    }
    let folder = folder.canonicalize()?;
    let file = folder.join(name).canonicalize()?;
    // A link could lead out of the folder.
    if !file.starts_with(&folder) || !file.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not beside the scan"));
    }
    let mut text = Vec::new();
    File::open(file)?.take(MOST_BYTES).read_to_end(&mut text)?;
    Ok(text)
}
