//! ESRI ASCII grid: a raster of heights, as terrain models and profilometers deliver it.
//!
//! A header of names and numbers gives the numbers of columns and rows, the place of the lower left
//! corner or cell, the size of the cells, and the number that stands for a cell without a height. Then come
//! the heights, the uppermost row first. How they are spread over lines does not matter.

use std::path::Path;

use super::{GridShape, LeftOut, Order, Points, PointsBuilder, ScanEnd, degrees};
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::{Error, Location, Result};

/// Heights are seen from above. From a place as many extents above them, all rays are parallel within half a
/// thousandth.
const ABOVE: f64 = 1000.0;

/// A number written with six digits, as `%g` and the streams of C++ do it, differs by at most this part from what it
/// was. The rounding to a number of 32 bits is less than that.
const SIX_DIGITS: f64 = 5e-6;

/// Whether `head` begins an ESRI ASCII grid: its first word is one of two names, and a whole number follows.
pub(super) fn is_grid(head: &[u8]) -> bool {
    let mut words = head.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let name = words.next().unwrap_or_default().to_ascii_lowercase();
    matches!(&name[..], b"ncols" | b"nrows") && words.next().and_then(whole).is_some()
}

/// What the header says.
#[derive(Default)]
struct HeightHeader {
    columns: Option<u64>,
    rows: Option<u64>,
    /// The lower left place along x and y, and whether it is a corner and not the middle of a cell.
    place: [Option<(f64, bool)>; 2],
    /// The size of a cell along x and y.
    cell: [Option<f64>; 2],
    no_data: Option<f64>,
}

impl HeightHeader {
    /// Takes one line of the header. `false` if it is none.
    fn take(&mut self, name: &[u8], value: &[u8]) -> bool {
        let number = number(value);
        match &name.to_ascii_lowercase()[..] {
            b"ncols" => self.columns = whole(value),
            b"nrows" => self.rows = whole(value),
            b"xllcorner" => self.place[0] = number.map(|x| (x, true)),
            b"xllcenter" => self.place[0] = number.map(|x| (x, false)),
            b"yllcorner" => self.place[1] = number.map(|y| (y, true)),
            b"yllcenter" => self.place[1] = number.map(|y| (y, false)),
            b"cellsize" => self.cell = [number; 2],
            b"dx" => self.cell[0] = number,
            b"dy" => self.cell[1] = number,
            b"nodata_value" | b"nodata" => self.no_data = number,
            _ => return false,
        }
        true
    }

    /// Whether a cell has no height: its number is the one of the header, though perhaps with fewer digits, or it is the
    /// largest of 32 bits, about which a header may be silent or more brief. No length is within a tenth of it.
    fn is_no_data(&self, height: f64) -> bool {
        let is_it = |no_data: f64| (height - no_data).abs() <= SIX_DIGITS * no_data.abs();
        height.abs() > f64::from(f32::MAX) / 10.0 || self.no_data.is_some_and(is_it)
    }

    /// The size and the places of the raster. `None` if something is missing or cannot be.
    fn raster(&self) -> Option<HeightRaster> {
        let axis = |axis: usize| {
            let cell = self.cell[axis].filter(|cell| *cell > 0.0 && cell.is_finite())?;
            let (place, is_corner) = self.place[axis].unwrap_or((0.0, true));
            let low = if is_corner { place + cell / 2.0 } else { place };
            low.is_finite().then_some([low, cell])
        };
        let raster =
            HeightRaster { columns: self.columns?, rows: self.rows?, axes: [axis(0)?, axis(1)?] };
        raster.columns.checked_mul(raster.rows).map(|_| raster)
    }
}

struct HeightRaster {
    columns: u64,
    rows: u64,
    /// Along x and y: the middle of the lowest cells, and the size of a cell.
    axes: [[f64; 2]; 2],
}

impl HeightRaster {
    /// The place of the cell with this number.
    fn place(&self, cell: u64) -> [f64; 2] {
        let (column, row) = (cell % self.columns, self.rows - 1 - cell / self.columns);
        let along = |[low, size]: [f64; 2], i: u64| low + i as f64 * size;
        [along(self.axes[0], column), along(self.axes[1], row)]
    }

    fn cells(&self) -> u64 {
        self.columns * self.rows
    }

    /// A place from which all of the raster is seen from above.
    fn above(&self, top: f64) -> [f64; 3] {
        let middle = |[low, size]: [f64; 2], count: u64| low + size * (count - 1) as f64 / 2.0;
        let [x, y] = self.axes;
        let extent = (x[1] * self.columns as f64).max(y[1] * self.rows as f64);
        [middle(x, self.columns), middle(y, self.rows), top + ABOVE * extent]
    }
}

pub(super) fn read(source: Source) -> Result<Points> {
    let mut builder = PointsBuilder::new(&source.path, false);
    builder.begin_scan(true);
    let path = source.path.clone();
    let mut reader = Reader { source, line: Vec::new(), header: HeightHeader::default(), builder };
    let more = reader.read_header()?;
    let Some(raster) = reader.header.raster() else {
        let what = "is a raster whose header lacks its size or that of its cells";
        return Err(reader.source.error(what, EXPORT_AGAIN));
    };
    if more {
        reader.read_heights(&raster)?;
    }
    finish(reader.builder, &raster, &path)
}

struct Reader {
    source: Source,
    line: Vec<u8>,
    header: HeightHeader,
    builder: PointsBuilder,
}

impl Reader {
    /// Reads up to the first line that is not of the header. `false` if there is none.
    fn read_header(&mut self) -> Result<bool> {
        while self.source.next_text_line(&mut self.line)? {
            let mut words = words(&self.line);
            match (words.next(), words.next()) {
                (None, _) => {}
                (Some(name), Some(value)) if self.header.take(name, value) => {}
                _ => return Ok(true),
            }
        }
        Ok(false)
    }

    /// Reads all heights, from the line at hand on.
    fn read_heights(&mut self, raster: &HeightRaster) -> Result<()> {
        let mut cells = 0;
        loop {
            for word in words(&self.line) {
                let Some(height) = number(word) else {
                    let text = excerpt(word);
                    let what = format!("has \u{201c}{text}\u{201d} for a height");
                    return Err(self.source.error(what, number_help(&text)));
                };
                if cells == raster.cells() {
                    let what = format!("has more heights than its {cells} cells");
                    return Err(self.source.error(what, EXPORT_AGAIN));
                }
                let [x, y] = raster.place(cells);
                match self.header.is_no_data(height) {
                    true => self.builder.leave_out(LeftOut::Marked)?,
                    false => self.builder.push([x, y, height], [0.0; 3])?,
                }
                cells += 1;
            }
            if !self.source.next_text_line(&mut self.line)? {
                break;
            }
        }
        if cells < raster.cells() {
            let what = format!("ends after {cells} of its {} cells", raster.cells());
            let error = Error::new(&self.source.path, what, EXPORT_AGAIN);
            return Err(error.at(Location::Element("cell", cells)));
        }
        Ok(())
    }
}

/// The numbers of a line, without the mark that ends old text files.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = line.split(u8::is_ascii_whitespace);
    words.filter(|word| !word.is_empty() && *word != b"\x1a")
}

fn finish(mut builder: PointsBuilder, raster: &HeightRaster, path: &Path) -> Result<Points> {
    let cloud = builder.cloud();
    let top = cloud.positions.iter().map(|p| p[2]).fold(f64::NEG_INFINITY, f64::max);
    let viewpoint = top.is_finite().then(|| raster.above(top)).filter(|v| v[2].is_finite());
    let shape = usize::try_from(raster.rows).ok().zip(usize::try_from(raster.columns).ok());
    let shape = shape.filter(|&(rows, columns)| rows > 1 && columns > 1);
    let grid = shape.map(|(rows, columns)| GridShape { rows, columns, order: Order::Rows });
    builder.end_scan(ScanEnd { viewpoint, grid, ..ScanEnd::default() })?;
    let cloud = builder.cloud();
    if let Some(grid) = &cloud.scans[0].grid {
        degrees::check_raster(path, cloud, grid, raster.axes.map(|[_, cell]| cell))?;
    }
    builder.finish()
}

fn number(word: &[u8]) -> Option<f64> {
    let word = std::str::from_utf8(word).ok()?;
    word.parse().ok().or_else(|| plain_number(word).parse().ok())
}

fn whole(word: &[u8]) -> Option<u64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
