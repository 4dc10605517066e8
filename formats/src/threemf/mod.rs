//! Reader of 3MF files (3D Manufacturing Format, core specification 1.3).
//!
//! It is written by hand on `zip` and `quick-xml`: of four crates that read 3MF, each loses shapes, names or components
//! without a word, panics, or takes gigabytes. A file is a package of parts (`package`), which are XML (`xml`). The model
//! (`model`) has objects, which are meshes (`shape`) or components of other objects, and a build, which places some of
//! them. `tree` checks how they refer to each other and makes the scene of them. A namespace counts by its address.

mod fault;
mod model;
mod package;
mod properties;
mod reader;
mod relationships;
mod shape;
mod tree;
mod utf16;
mod value;
mod xml;

use std::collections::BTreeMap;

use fault::PackageFault;
use model::{Model, ObjectKey};
use package::Package;
use relationships::Purpose;

use crate::scene::{Scene, SceneNote};
use crate::source::Source;
use crate::{Error, Result};

/// The most parts with objects of a file. Slicers write one for each object.
const MOST_MODELS: usize = 10_000;

/// Whether `head` begins a ZIP archive.
pub(crate) fn is_zip(head: &[u8]) -> bool {
    head.starts_with(b"PK\x03\x04")
}

pub(crate) fn read(source: Source) -> Result<Scene> {
    let path = source.path.clone();
    let mut package = Package::open(source)?;
    let bytes = package.size();
    let read = read_package(&mut package);
    let (models, tickets) = read.map_err(|fault| Error::from_fault(&path, fault))?;
    let mut scene = Scene::new(&path, bytes);
    let made = tree::make(models, &mut scene);
    made.map_err(|fault| Error::from_fault(&path, fault))?;
    if tickets > 1 {
        scene.notes.push(SceneNote::Irregular("several print tickets", tickets));
    }
    Ok(scene)
}

impl Error {
    fn from_fault(path: &std::path::Path, fault: PackageFault) -> Error {
        let error = Error::new(path, fault.what, fault.help);
        match fault.place {
            Some(place) => error.at(place),
            None => error,
        }
    }
}

/// Reads the models of a package. The first one is its root. Returns the number of print tickets, too.
fn read_package(package: &mut Package) -> std::result::Result<(Vec<Model>, u64), PackageFault> {
    let root = root_part(package)?;
    let mut tickets = 0;
    let mut numbers = BTreeMap::from([(root.clone(), 0)]);
    let mut paths = vec![root];
    let mut models: Vec<Model> = Vec::new();
    while let Some(path) = paths.get(models.len()).cloned() {
        let number = models.len();
        for relation in relationships::read(package, &path)? {
            match relation.purpose {
                Purpose::Keys => return Err(PackageFault::encrypted()),
                Purpose::PrintTicket => tickets += 1,
                Purpose::Model | Purpose::Other => {}
            }
        }
        let model = reader::read(package.part(&path)?, number == 0)
            .map_err(|fault| fault.within(&path, number))?;
        // Parts are read in the order in which items and components name them.
        for named in &model.paths {
            let next = numbers.len();
            if !numbers.contains_key(named) {
                if next >= MOST_MODELS {
                    return Err(PackageFault::new("has more than 10,000 parts"));
                }
                numbers.insert(named.clone(), next);
                paths.push(named.clone());
            }
        }
        models.push(model);
    }
    for (number, model) in models.iter_mut().enumerate() {
        for key in model.keys_mut() {
            key.resolve(number, &numbers);
        }
    }
    Ok((models, tickets))
}

/// The name of the part with the build.
fn root_part(package: &mut Package) -> std::result::Result<String, PackageFault> {
    let mut roots = Vec::new();
    for relation in relationships::read(package, "")? {
        match relation.purpose {
            Purpose::Model => roots.push(relation.target),
            Purpose::Keys => return Err(PackageFault::encrypted()),
            Purpose::PrintTicket | Purpose::Other => {}
        }
    }
    match (roots.pop(), roots.len()) {
        (Some(root), 0) => Ok(root),
        (Some(_), _) => Err(PackageFault::new("names several parts as its 3D model")),
        (None, _) => Err(PackageFault::no_model()),
    }
}

impl ObjectKey {
    /// Puts the number of the part in the place of its name.
    fn resolve(&mut self, own: usize, numbers: &BTreeMap<String, usize>) {
        self.model = match &self.path {
            Some(path) => numbers.get(path).copied().unwrap_or(usize::MAX),
            None => own,
        };
    }
}
