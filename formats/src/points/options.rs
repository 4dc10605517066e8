//! What is read of a cloud.

use std::io::Read;
use std::path::Path;

use super::read::{self, Content, SceneContent};
use super::{Columns, Points};
use crate::Result;
use crate::source::Source;

/// Which points of a cloud are read. By default, all valid ones are.
///
/// ```
/// use formats::points::ReadOptions;
///
/// // Only the ground.
/// let options = ReadOptions { classes: vec![2], ..ReadOptions::default() };
/// let text = std::io::Cursor::new("0 0 1\n1 0 1\n");
/// // Text has no classes.
/// assert!(options.read_points_from("scan.xyz".as_ref(), text).is_err());
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ReadOptions {
    /// Only points of these classes are read. If there are none, all are read except the
    /// classes of noise, 7 and 18. Only LAS and LAZ have classes. Other files are refused.
    pub classes: Vec<u8>,
    /// Only points whose intensity is at least this number are read, in the unit of
    /// the file. Only the intensities of LAS, LAZ and E57 are read. Other files are
    /// refused.
    pub min_intensity: Option<f64>,
    /// These columns of a text file hold the coordinates, and perhaps the normals. Without it
    /// the names of the columns or their numbers tell it. Other files are refused.
    pub columns: Option<Columns>,
}

impl ReadOptions {
    /// Reads a file as [`read_points`](super::read_points) does, with these options.
    ///
    /// # Errors
    /// Those of [`read_points`](super::read_points). In addition, the file may not have
    /// the classes or intensities that these options ask for.
    pub fn read_points(&self, path: &Path) -> Result<Points> {
        read::points(path, self.read_content(path)?)
    }

    /// Reads a stream as [`read_points_from`](super::read_points_from) does, with these
    /// options.
    ///
    /// # Errors
    /// Those of [`ReadOptions::read_points`].
    pub fn read_points_from(&self, name: &Path, content: impl Read + 'static) -> Result<Points> {
        read::points(name, self.read_content_from(name, content)?)
    }

    /// Reads a file as [`read_content`](super::read_content) does, with these options. They
    /// do not matter for a mesh.
    ///
    /// # Errors
    /// Those of [`read_content`](super::read_content) and [`ReadOptions::read_points`].
    pub fn read_content(&self, path: &Path) -> Result<Content> {
        self.read_scene(path)?.into_content()
    }

    /// Reads a file as [`ReadOptions::read_content`] does, but a mesh as the scene that the file has.
    ///
    /// # Errors
    /// Those of [`ReadOptions::read_content`], but a scene may place its meshes as often as it likes.
    pub fn read_scene(&self, path: &Path) -> Result<SceneContent> {
        read::read(Source::open(path)?, self)
    }

    /// Reads a stream as [`ReadOptions::read_content_from`] does, but a mesh as the scene that it has.
    ///
    /// # Errors
    /// Those of [`ReadOptions::read_scene`].
    pub fn read_scene_from(
        &self,
        name: &Path,
        content: impl Read + 'static,
    ) -> Result<SceneContent> {
        read::read(Source::new(name, content, None, None)?, self)
    }

    /// Reads a mesh or a cloud from memory or any other stream, whichever it holds. Errors call it
    /// `name`. Its content decides on the format, and the extension of `name` only where the content
    /// does not tell it. A glTF file from a stream may not refer to other files.
    ///
    /// ```
    /// use formats::{Content, points::ReadOptions};
    ///
    /// let text = std::io::Cursor::new("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    /// let content = ReadOptions::default().read_content_from("stdin".as_ref(), text)?;
    /// assert!(matches!(content, Content::Mesh(soup) if soup.points.len() == 3));
    /// # Ok::<(), formats::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`ReadOptions::read_content`].
    pub fn read_content_from(&self, name: &Path, content: impl Read + 'static) -> Result<Content> {
        self.read_scene_from(name, content)?.into_content()
    }
}
