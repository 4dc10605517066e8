//! PLY without faces: a cloud of points, perhaps in a range grid.
//!
//! Stanford's range scans have an element `range_grid` with a list for each cell:
//! empty, or the number of its vertex. The header's `obj_info` lines `num_cols`
//! and `num_rows` give the shape of the grid.

use ply_rs::ply::{PropertyAccess, PropertyAccessResult, PropertyType};

use super::header::{Element, Header};
use super::rows::VertexNumbers;
use super::{PlyBody, check_end, each_row, no_list, skip, vertex};
use crate::points::{GridShape, Note, Order, PointsBuilder, ScanEnd, ScanGrid};
use crate::source::EXPORT_AGAIN;
use crate::words::plural;
use crate::{Error, Location, Points, Result};

const GRID: &str = "range_grid";

/// Whether the header announces no faces.
pub(super) fn is_cloud(header: &Header) -> bool {
    let has_faces = |e: &Element| matches!(e.name.as_str(), "face" | "tristrips") && e.count > 0;
    !header.elements.iter().any(has_faces)
}

pub(super) fn read(mut body: PlyBody, header: &Header) -> Result<Points> {
    let vertices = header.elements.iter().find(|e| e.name == "vertex");
    let has_normals = vertices.is_some_and(|e| NORMAL.iter().all(|name| has(e, name)));
    let mut builder = PointsBuilder::new(&body.source.path, has_normals);
    let has_grid = header.elements.iter().any(|e| e.name == GRID && e.count > 0);
    builder.begin_scan(has_grid);
    let mut cells = None;
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" if element.count > 0 => read_points(&mut body, element, &mut builder)?,
            GRID if element.count > 0 => cells = Some(read_grid(&mut body, element)?),
            _ => skip(&mut body, element)?,
        }
    }
    check_end(&mut body)?;
    if let (Some(cells), Some(vertices)) = (&cells, vertices) {
        check_grid(&body, cells, vertices.count)?;
    }
    let grid = cells.and_then(|cells| shape(header, cells));
    if has_grid && grid.is_none() {
        builder.cloud().notes.push(Note::GridIgnored);
    }
    if header.has_splats() {
        builder.cloud().notes.push(Note::Splats);
    }
    if let Some((unit, comment)) = &header.unit {
        builder.cloud().unit = Some(*unit);
        builder.cloud().notes.push(Note::UnitByComment { comment: comment.clone() });
    }
    builder.end_scan(ScanEnd { grid, ..ScanEnd::default() })?;
    builder.finish()
}

/// What a normal's components are called. Other names are rare, and lost.
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];

fn has(element: &Element, name: &str) -> bool {
    matches!(element.property(name), Some(PropertyType::Scalar(_)))
}

fn read_points(body: &mut PlyBody, element: &Element, builder: &mut PointsBuilder) -> Result<()> {
    for axis in ["x", "y", "z"] {
        if !has(element, axis) {
            let what = format!("has vertices without {axis}");
            return Err(Error::new(&body.source.path, what, EXPORT_AGAIN));
        }
    }
    let wanted = |name: &str| matches!(name, "x" | "y" | "z") || NORMAL.contains(&name);
    each_row(body, element, wanted, |_, _, row: PointRow| builder.push(row.xyz, row.normal))?;
    let names = element.properties.iter().map(|(name, _)| name.as_str());
    builder.cloud().lost.count(names, element.count);
    Ok(())
}

/// The vertex number of each cell, or [`ScanGrid::EMPTY`].
fn read_grid(body: &mut PlyBody, element: &Element) -> Result<Vec<u32>> {
    let list = element.index_list().ok_or_else(|| no_list(body, element))?;
    let mut cells = Vec::new();
    each_row(
        body,
        element,
        |name| name == list,
        |source, i, row: VertexNumbers| {
            let index = row.indices().next();
            let cell = index.map_or(Some(ScanGrid::EMPTY), vertex);
            let cell = cell.ok_or_else(|| {
                let what = "has a cell of its range grid with a negative vertex number";
                Error::new(&source.path, what, EXPORT_AGAIN).at(Location::Element("cell", i))
            })?;
            cells.push(cell);
            Ok(())
        },
    )?;
    Ok(cells)
}

fn check_grid(body: &PlyBody, cells: &[u32], vertices: u64) -> Result<()> {
    let wrong = |&cell: &u32| cell != ScanGrid::EMPTY && u64::from(cell) >= vertices;
    let Some(i) = cells.iter().position(wrong) else { return Ok(()) };
    let what = format!(
        "has a range grid with vertex {}, but only {}",
        cells[i],
        plural(vertices, "vertex")
    );
    let error = Error::new(&body.source.path, what, EXPORT_AGAIN);
    Err(error.at(Location::Element("cell", i as u64)))
}

/// How the cells form a grid, if the header says it and the counts agree.
fn shape(header: &Header, cells: Vec<u32>) -> Option<GridShape> {
    let (rows, columns) = (header.info("num_rows")?, header.info("num_cols")?);
    let (rows, columns) = (usize::try_from(rows).ok()?, usize::try_from(columns).ok()?);
    let fits = rows > 1 && columns > 1 && rows.checked_mul(columns) == Some(cells.len());
    fits.then_some(GridShape { rows, columns, order: Order::Indexed(cells) })
}

/// A vertex of a cloud. What the file does not have stays zero.
struct PointRow {
    xyz: [f64; 3],
    normal: [f64; 3],
}

impl PointRow {
    fn set(&mut self, name: &str, value: f64) -> PropertyAccessResult {
        match name {
            "x" => self.xyz[0] = value,
            "y" => self.xyz[1] = value,
            "z" => self.xyz[2] = value,
            "nx" => self.normal[0] = value,
            "ny" => self.normal[1] = value,
            "nz" => self.normal[2] = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

impl PropertyAccess for PointRow {
    fn new() -> Self {
        PointRow { xyz: [0.0; 3], normal: [0.0; 3] }
    }

    super::rows::coordinates!(set_char: i8, set_uchar: u8, set_short: i16, set_ushort: u16,
        set_int: i32, set_uint: u32, set_float: f32, set_double: f64);
}
