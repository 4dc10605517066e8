//! What every command does with its scan first: read it, settle its unit.

use std::path::{Path, PathBuf};

use formats::{LengthUnit, Soup};
use scan2step::geometry::Point;
use scan2step::mesh::{self, Components, Outer};

use super::Failure;
use super::args::Piece;
use super::places::Places;

/// A scan that was read. Its soup is dropped once the mesh is made.
pub struct Scan {
    pub path: PathBuf,
    pub unit: LengthUnit,
    pub unit_assumed: bool,
    /// Vertices and triangles of the file, polygons fanned, unrepaired.
    pub counts: [usize; 2],
    /// The mean colour of its vertices, if they have one.
    pub colour: Option<[u8; 3]>,
    soup: Soup,
}

impl Scan {
    pub fn read(piece: &Piece) -> Result<Scan, Failure> {
        let soup = formats::read_scan(&piece.scan)?;
        let declared = piece.scale.units.map(LengthUnit::from).or(soup.unit);
        let counts = [soup.points.len(), soup.polygons.triangle_count()];
        Ok(Scan {
            path: piece.scan.clone(),
            unit: declared.unwrap_or(LengthUnit::Millimetre),
            unit_assumed: declared.is_none(),
            counts,
            colour: soup.colour,
            soup,
        })
    }

    /// The places in mm.
    pub fn resolve(&self, places: &Places) -> Result<Vec<Point>, Failure> {
        places.resolve(&self.soup, self.unit.in_mm()).map_err(|e| self.unresolved(&e))
    }

    fn unresolved(&self, error: &str) -> Failure {
        Failure {
            error: format!("{}: {error}", self.path.display()),
            help: "count vertices as the file does, from 0".into(),
        }
    }

    /// The outer loop that the user named.
    pub fn outer(&self, piece: &Piece) -> Result<Outer, Failure> {
        let Some(place) = piece.outer else { return Ok(Outer::Auto) };
        let place = place.resolve(&self.soup, self.unit.in_mm());
        place.map(Outer::Near).map_err(|e| self.unresolved(&e))
    }

    /// The mesh and its components; the soup goes.
    pub fn components(mut self) -> Result<(Scan, Components), Failure> {
        let soup = std::mem::take(&mut self.soup);
        let build = mesh::from_soup(&soup, self.unit.in_mm());
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
