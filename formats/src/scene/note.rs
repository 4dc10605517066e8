//! What the user should know about how a scene was read.

use std::fmt;

use crate::words::plural;

/// What a file has and a [`Scene`](super::Scene) does not, or what was read in an unusual way.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum SceneNote {
    /// 3MF: objects for supports of a print.
    Supports(u64),
    /// 3MF: objects of the type "other".
    OtherObjects(u64),
    /// 3MF: objects that no item of the build uses. The meshes among them are left out.
    NotBuilt(u64),
    /// 3MF: a kind of shape that is not read, and the number of objects that have it beside their mesh.
    NotRead(&'static str, u64),
    /// glTF: skins or morph targets may have moved the mesh.
    Undeformed,
    /// OBJ: files of materials that cannot be read.
    NoMaterials(String),
    /// There are too many named groups, so that none is kept.
    TooManyGroups(u64),
    /// Rules of the format that are broken but do not concern shapes, and the number of places.
    Irregular(&'static str, u64),
}

impl fmt::Display for SceneNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SceneNote::Supports(n) => {
                write!(f, "{} for supports is left out", plural(*n, "object"))
            }
            SceneNote::OtherObjects(n) => {
                write!(f, "{} of the type \u{201c}other\u{201d} is left out", plural(*n, "object"))
            }
            SceneNote::NotBuilt(n) => {
                write!(f, "{} that the build does not use is left out", plural(*n, "object"))
            }
            SceneNote::NotRead(kind, n) => {
                write!(f, "{kind} of {} are not read; the meshes are", plural(*n, "object"))
            }
            SceneNote::Undeformed => f.write_str("skins and morph targets are not applied"),
            SceneNote::NoMaterials(why) => {
                write!(f, "there are no colours, because {why}")
            }
            SceneNote::TooManyGroups(n) => {
                write!(
                    f,
                    "the file has {}, which are too many to be parts",
                    plural(*n, "named group")
                )
            }
            SceneNote::Irregular(what, n) => {
                write!(f, "the file has {what} ({}), which shapes do not need", plural(*n, "time"))
            }
        }
    }
}
