//! Reading a cloud of whichever format.

use std::io::Read;
use std::path::Path;

use super::{Note, Points, PointsBuilder, ReadOptions, ScanEnd, e57, grid, las, pcd, ptx, text};
use crate::read::{self, READABLE, after_mark, by_content, foreign};
use crate::scene::{Scene, SceneMesh};
use crate::source::Source;
use crate::{Error, Format, Result, Soup, ply};

/// A format of clouds that [`read_points`] reads, plain or gzipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum PointFormat {
    /// ASTM E2807, scans of terrestrial scanners.
    E57,
    /// LAS of any version, or LAZ, which is compressed LAS. COPC is LAZ.
    Las,
    /// Stanford polygon file without faces, ascii or binary.
    Ply,
    /// Point Cloud Data, ascii, binary or compressed.
    Pcd,
    /// Leica's text format of scans on a grid.
    Ptx,
    /// Columns of text whose unit is the metre, mostly after a line with their
    /// number.
    Pts,
    /// Any other columns of text: XYZ, TXT, ASC, CSV.
    Text,
    /// ESRI ASCII grid, a raster of heights. It has often the extension of text (ASC).
    Grid,
}

impl PointFormat {
    /// The format that the extension of `path` means, gzipped or not, if it means
    /// one. The file is not looked at. `.ply` may also be a mesh.
    pub fn by_extension(path: &Path) -> Option<PointFormat> {
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let name = name.strip_suffix(".gz").unwrap_or(&name);
        match name.rsplit_once('.')?.1 {
            "e57" => Some(PointFormat::E57),
            "las" | "laz" => Some(PointFormat::Las),
            "ply" => Some(PointFormat::Ply),
            "pcd" => Some(PointFormat::Pcd),
            "ptx" => Some(PointFormat::Ptx),
            "pts" => Some(PointFormat::Pts),
            "xyz" | "txt" | "asc" | "csv" => Some(PointFormat::Text),
            _ => None,
        }
    }

    /// Whether the extension of `path` means columns of text, and the file has no line at its beginning that
    /// can be a point: notes or a table, whose extensions (`.txt`, `.csv`) are the same. A file that cannot be
    /// opened is none of these.
    pub fn is_other_text(path: &Path) -> bool {
        let is_text = PointFormat::by_extension(path) == Some(PointFormat::Text);
        let is_points = |head: &[u8]| grid::is_grid(head) || text::is_points(head);
        is_text && Source::open(path).is_ok_and(|source| !is_points(&source.head))
    }
}

/// What a scan file holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Polygons over points.
    Mesh(Soup),
    /// Points alone.
    Points(Points),
}

/// What a scan file holds, with all places and names of its meshes.
#[derive(Debug, Clone, PartialEq)]
pub enum SceneContent {
    /// Meshes in their places.
    Scene(Scene),
    /// Points alone.
    Points(Points),
}

impl SceneContent {
    /// The same with all meshes as one.
    ///
    /// # Errors
    /// Those of [`Scene::into_soup`].
    pub fn into_content(self) -> Result<Content> {
        Ok(match self {
            SceneContent::Scene(scene) => Content::Mesh(scene.into_soup()?),
            SceneContent::Points(points) => Content::Points(points),
        })
    }
}

/// Reads the mesh or the cloud in the file at `path`, whichever it holds. A mesh
/// format without faces (PLY, OBJ, OFF) holds a cloud.
///
/// # Errors
/// Those of [`read_scan`](crate::read_scan) and [`read_points`].
pub fn read_content(path: &Path) -> Result<Content> {
    ReadOptions::default().read_content(path)
}

/// Reads the cloud of points in the file at `path`: its valid points in the file's
/// order, with their normals and their grids.
///
/// # Errors
/// The file cannot be read, is damaged, contradicts itself, holds a mesh, or has
/// no valid point. Memory grows with what the file really holds, whatever it
/// claims.
pub fn read_points(path: &Path) -> Result<Points> {
    ReadOptions::default().read_points(path)
}

/// Reads a cloud as [`read_points`] does, but from memory or any other stream.
/// `name` is what errors call the file. Its extension decides where the content
/// does not tell the format.
///
/// ```
/// let text = "x;y;z\n400000,125;5800000,5;1,25\n400000,25;5800000,5;1,5\n";
/// let content = std::io::Cursor::new(text);
/// let points = formats::read_points_from("upload.csv".as_ref(), content)?;
/// assert_eq!(points.absolute(0), [400000.125, 5800000.5, 1.25]);
/// # Ok::<(), formats::Error>(())
/// ```
///
/// # Errors
/// Those of [`read_points`].
pub fn read_points_from(name: &Path, content: impl Read + 'static) -> Result<Points> {
    ReadOptions::default().read_points_from(name, content)
}

pub(super) fn points(path: &Path, content: Content) -> Result<Points> {
    match content {
        Content::Points(points) => Ok(points),
        Content::Mesh(_) => {
            let help = "Read it as a mesh.";
            Err(Error::new(path, "has faces: it is a mesh, not a cloud of points", help))
        }
    }
}

/// Reads whatever `source` holds.
pub(super) fn read(source: Source, options: &ReadOptions) -> Result<SceneContent> {
    let Some(format) = recognise(&source)? else {
        let path = source.path.clone();
        let scene = read::read_unchecked(source)?;
        return match scene.has_polygons() {
            true => Ok(SceneContent::Scene(scene)),
            false => {
                check_options(&path, None, options)?;
                from_soup(&path, scene.into_soup()?).map(SceneContent::Points)
            }
        };
    };
    check_options(&source.path, Some(format), options)?;
    let columns = options.columns.as_ref();
    match format {
        PointFormat::E57 => e57::read(source, options).map(SceneContent::Points),
        PointFormat::Las => las::read(source, options).map(SceneContent::Points),
        PointFormat::Ply => {
            let (head, path) = (source.head.clone(), source.path.clone());
            let content = ply::read_content(source);
            let content = content.map_err(|e| crate::damage::explain(e, Format::Ply, &head));
            content.map(|content| match content {
                Content::Mesh(soup) => {
                    SceneContent::Scene(Scene::of_mesh(path, SceneMesh::plain(soup)))
                }
                Content::Points(points) => SceneContent::Points(points),
            })
        }
        PointFormat::Pcd => pcd::read(source).map(SceneContent::Points),
        PointFormat::Ptx => ptx::read(source).map(SceneContent::Points),
        PointFormat::Pts => text::read(source, true, columns).map(SceneContent::Points),
        PointFormat::Text => text::read(source, false, columns).map(SceneContent::Points),
        PointFormat::Grid => grid::read(source).map(SceneContent::Points),
    }
}

/// Refuses options that a format cannot fulfil.
fn check_options(path: &Path, format: Option<PointFormat>, options: &ReadOptions) -> Result<()> {
    let has_classes = format == Some(PointFormat::Las);
    let has_columns = matches!(format, Some(PointFormat::Pts | PointFormat::Text));
    let has_intensities = has_classes || format == Some(PointFormat::E57);
    let what = if !options.classes.is_empty() && !has_classes {
        "is of a format without classes of points"
    } else if options.min_intensity.is_some() && !has_intensities {
        "is of a format whose intensities are not read"
    } else if options.columns.is_some() && !has_columns {
        "is of a format that says itself what its columns hold"
    } else {
        return Ok(());
    };
    let help = match options.columns {
        Some(_) => "Read it without naming columns.",
        None => "Read all of its points, or save it as LAS.",
    };
    Err(Error::new(path, what, help))
}

/// The format of a cloud, or `None` for a mesh of another format than PLY.
fn recognise(source: &Source) -> Result<Option<PointFormat>> {
    let head = source.head.as_slice();
    if head.is_empty() {
        return Err(Error::new(&source.path, "is empty", "Copy or export the scan again."));
    }
    if let Some(format) = by_content(source) {
        return Ok((format == Format::Ply).then_some(PointFormat::Ply));
    }
    if head.starts_with(e57::SIGNATURE) {
        return Ok(Some(PointFormat::E57));
    }
    if head.starts_with(las::SIGNATURE) {
        return Ok(Some(PointFormat::Las));
    }
    let text = after_mark(head);
    if pcd::is_pcd(text) {
        return Ok(Some(PointFormat::Pcd));
    }
    if let Some((foreign, help)) = foreign(head) {
        return Err(Error::new(&source.path, format!("is {foreign}"), help));
    }
    // A mesh's extension decides about numbers that have nothing else to tell.
    let extension = PointFormat::by_extension(&source.path);
    if crate::obj::is_obj(text)
        || extension.is_none() && Format::by_extension(&source.path).is_some()
    {
        return Ok(None);
    }
    if grid::is_grid(text) {
        return Ok(Some(PointFormat::Grid));
    }
    if ptx::is_ptx(text) {
        return Ok(Some(PointFormat::Ptx));
    }
    if text::is_points(text) {
        let is_pts = match extension {
            Some(PointFormat::Text) => false,
            Some(PointFormat::Pts) => true,
            _ => text::has_count(text),
        };
        return Ok(Some(if is_pts { PointFormat::Pts } else { PointFormat::Text }));
    }
    if extension.is_none() && crate::stl::begins_as_binary(head) {
        return Ok(None);
    }
    let unknown =
        || Error::new(&source.path, "is of no known format of meshes or points", READABLE);
    extension.ok_or_else(unknown).map(Some)
}

/// The points of a mesh format that has no faces.
fn from_soup(path: &Path, soup: Soup) -> Result<Points> {
    let mut builder = PointsBuilder::new(path, false);
    builder.cloud().unit = soup.unit;
    let note = soup.unit_comment.map(|comment| Note::UnitByComment { comment });
    builder.cloud().notes.extend(note);
    builder.begin_scan(false);
    for xyz in soup.points {
        builder.push(xyz, [0.0; 3])?;
    }
    builder.end_scan(ScanEnd::default())?;
    builder.finish()
}
