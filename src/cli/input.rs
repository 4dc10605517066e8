//! The scan of a command: its file, its unit and its mesh.

use std::path::{Path, PathBuf};

use formats::{LengthUnit, Soup};
use scan2step::Options;
use scan2step::mesh::{self, Components, Outer};
use scan2step::report::ScanSource;

use super::Failure;
use super::args::Piece;

/// A scan that was read. Its soup is dropped once the mesh is made.
pub struct Scan {
    pub path: PathBuf,
    /// Its unit, and the counts of the file.
    pub source: ScanSource,
    /// The mean colour of its vertices, if they have one.
    pub colour: Option<[u8; 3]>,
    soup: Soup,
}

impl Scan {
    pub fn read(piece: &Piece) -> Result<Scan, Failure> {
        let soup = formats::read_scan(&piece.scan)?;
        let declared = piece.scale.units.map(LengthUnit::from).or(soup.unit);
        let source = ScanSource {
            file: piece.scan.display().to_string(),
            unit: declared.unwrap_or(LengthUnit::Millimetre),
            unit_assumed: declared.is_none(),
            vertices: soup.points.len(),
            triangles: soup.polygons.triangle_count(),
        };
        Ok(Scan { path: piece.scan.clone(), source, colour: soup.colour, soup })
    }

    /// The name of its file without the folder.
    pub fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// The options with the points of the places that they name.
    pub fn resolved(&self, options: &Options) -> Result<Options, Failure> {
        options.resolved(&self.soup).map_err(|e| stopped(&self.path, &e))
    }

    /// The outer loop that the user named.
    pub fn outer(&self, piece: &Piece) -> Result<Outer, Failure> {
        let Some(place) = piece.outer else { return Ok(Outer::Auto) };
        let place = place.0.resolve(&self.soup, self.source.unit.in_mm());
        place.map(Outer::Near).map_err(|e| stopped(&self.path, &e))
    }

    /// The mesh and its components. The soup is dropped.
    pub fn components(mut self) -> Result<(Scan, Components), Failure> {
        let soup = std::mem::take(&mut self.soup);
        let build = mesh::from_soup(&soup, self.source.unit.in_mm());
        let build = build.map_err(|e| stopped(&self.path, &e))?;
        drop(soup);
        Ok((self, Components::new(build)))
    }
}

/// What stopped the work on a scan.
pub fn stopped(scan: &Path, error: &scan2step::Error) -> Failure {
    match error {
        // It names its own file.
        scan2step::Error::File(e) => Failure { error: e.to_string(), help: e.help.clone() },
        e => Failure { error: format!("{}: {e}", scan.display()), help: e.help() },
    }
}
