//! The scan of a command: its file, its unit and its mesh.

use std::io::stdin;
use std::path::{Path, PathBuf};

use formats::scene::{SceneMesh, UpAxis};
use formats::{Content, Points, SceneContent, Soup};
use scan2step::mesh::{Components, Outer};
use scan2step::report::ScanSource;
use scan2step::{Options, Progress};

use super::Failure;
use super::args::{Piece, Up, cad_file};
use super::assembly::Y_UP;

/// A scan that was read: a mesh or a cloud of points. Its content is dropped once the mesh is made.
pub(crate) struct ReadScan {
    pub path: PathBuf,
    /// Its unit, the counts of the file, and what is known of a cloud.
    pub source: ScanSource,
    /// The mean colour of its vertices, if they have one.
    pub colour: Option<[u8; 3]>,
    /// What the user should know about how the file was read.
    pub notes: Vec<String>,
    /// The mesh with the colours of its polygons, if there are several.
    pub painted: Option<SceneMesh>,
    content: Content,
}

impl ReadScan {
    /// A scan whose file was read. The meshes of a scene are one.
    pub(crate) fn of(piece: &Piece, content: SceneContent) -> Result<ReadScan, Failure> {
        let name = &piece.scan.name;
        let (of_scene, painted) = match &content {
            SceneContent::Scene(scene) => {
                let notes = scene.notes.iter().map(ToString::to_string);
                let axes = scene.is_y_up.then(|| Y_UP.to_string());
                (notes.chain(axes).collect(), scene.painted()?)
            }
            SceneContent::Points(_) => (Vec::new(), None),
        };
        let content = match content.into_content()? {
            Content::Mesh(soup) if piece.cloud.remesh => Content::Points(Points::of_mesh(&soup)),
            other => other,
        };
        let named = ReadScan::options(piece)?;
        let file = name.display().to_string();
        let (source, colour, notes) = match &content {
            Content::Mesh(soup) => {
                let unused = piece.cloud.unused_in_mesh().map(str::to_owned);
                let comment = soup.unit_comment.as_ref().filter(|_| piece.scale.units.is_none());
                let of_comment = comment.map(|comment| {
                    format!("the unit is that of the comment \u{201c}{comment}\u{201d}")
                });
                let notes = of_scene.into_iter().chain(of_comment).chain(unused).collect();
                (ScanSource::of(file, soup, &named), soup.colour, notes)
            }
            Content::Points(cloud) => {
                (ScanSource::of_cloud(file, cloud, &named), None, cloud.remarks())
            }
        };
        Ok(ReadScan { path: name.clone(), source, colour, notes, painted, content })
    }

    /// The options that decide how its mesh is made.
    pub(crate) fn options(piece: &Piece) -> Result<Options, Failure> {
        let options = piece.cloud.options(&piece.scale, &piece.crop).build();
        options.map_err(|e| stopped(&piece.scan.name, &e))
    }

    /// The name of its file without the folder.
    pub(crate) fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// The options with the points of the places that they name.
    pub(crate) fn resolved(&self, options: &Options) -> Result<Options, Failure> {
        let resolved = match &self.content {
            Content::Mesh(soup) => options.resolved(soup),
            Content::Points(cloud) => options.resolved_in_cloud(cloud),
        };
        resolved.map_err(|e| stopped(&self.path, &e))
    }

    /// The outer loop that the user named.
    pub(super) fn outer(&self, piece: &Piece) -> Result<Outer, Failure> {
        let Some(place) = piece.outer else { return Ok(Outer::Auto) };
        let mm = self.source.unit.in_mm();
        let place = match &self.content {
            Content::Mesh(soup) => place.0.resolve(soup, mm),
            Content::Points(cloud) => place.0.resolve_in_cloud(cloud, mm),
        };
        place.map(Outer::Near).map_err(|e| stopped(&self.path, &e))
    }

    /// The mesh and its components. The content of the file is dropped.
    pub(crate) fn components(
        mut self,
        options: &Options,
        progress: &mut Progress,
    ) -> Result<(ReadScan, Components), Failure> {
        let content = std::mem::replace(&mut self.content, Content::Mesh(Soup::default()));
        let components = match content {
            Content::Mesh(soup) => scan2step::mesh_components(&soup, options),
            Content::Points(cloud) => {
                scan2step::cloud_components(cloud, options, progress).map(|(components, report)| {
                    self.source = self.source.clone().meshed(&report);
                    components
                })
            }
        };
        components.map_err(|e| stopped(&self.path, &e)).map(|components| (self, components))
    }
}

/// What the file of a scan holds.
pub(crate) fn read_content(piece: &Piece) -> Result<SceneContent, Failure> {
    let reading = piece.cloud.reading();
    let name = &piece.scan.name;
    let content = match piece.scan.is_stdin {
        true => reading.read_scene_from(name, stdin())?,
        false => reading.read_scene(name).map_err(|error| no_scan(name, error))?,
    };
    let up = match piece.scale.up {
        Up::Keep => return Ok(content),
        Up::Y => UpAxis::Y,
        Up::Z => UpAxis::Z,
    };
    match content {
        SceneContent::Scene(scene) => Ok(SceneContent::Scene(scene.with_up(up))),
        // z points up in all formats of clouds.
        SceneContent::Points(_) if up == UpAxis::Y => Err(Failure {
            error: format!("{}: is a cloud of points, which --up y does not turn", name.display()),
            help: "leave out --up: z points up in clouds".into(),
        }),
        points => Ok(points),
    }
}

/// The error of a file that could not be read as a scan, with the command that takes it.
fn no_scan(path: &Path, error: formats::Error) -> Failure {
    let (failure, name) = (Failure::from(error), path.display());
    let help = if path.is_dir() {
        format!("name a scan in it, or convert all of them: scan2step batch {name} --out cad/")
    } else if cad_file(&name.to_string()).is_ok() && path.exists() {
        format!("to measure a CAD file against its scan: scan2step check {name} SCAN")
    } else {
        return failure;
    };
    Failure { help, ..failure }
}

/// What stopped the work on a scan.
pub(crate) fn stopped(scan: &Path, error: &scan2step::Error) -> Failure {
    match error {
        // It names its own file.
        scan2step::Error::File(e) => Failure { error: e.to_string(), help: e.help.clone() },
        e => Failure { error: format!("{}: {e}", scan.display()), help: e.help() },
    }
}
