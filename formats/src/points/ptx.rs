//! PTX, the text format of Leica's scanners: one or more scans, each on a grid.
//!
//! A scan begins with ten lines: the numbers of columns and rows, the scanner's
//! position and its three axes, and a matrix of four rows that places the scan.
//! (It is written for row vectors, so that its last row is the translation.)
//! Then comes a line for each cell of the grid, column by column: a point in
//! the scanner's frame, an intensity, and perhaps a colour. `0 0 0` means that
//! the scanner saw nothing.

use super::{GridShape, LeftOut, Note, Order, Points, PointsBuilder, Pose, ScanEnd};
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::{excerpt, number_help, plain_number};
use crate::{Error, LengthUnit, Location, Result};

/// A placement whose volume is less than this part of what its axes span is flat.
/// Rounded rotations keep all of it to three digits.
const FLAT: f64 = 1e-6;

/// Whether `head` begins a PTX file: two lines with one integer each, and one with
/// three numbers.
pub(super) fn is_ptx(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let mut lines = text.split(|b| matches!(b, b'\r' | b'\n')).map(<[u8]>::trim_ascii);
    let mut next = || lines.by_ref().find(|line| !line.is_empty()).unwrap_or_default();
    integer(next()).is_some()
        && integer(next()).is_some()
        && numbers::<3>(next()).is_some_and(|(_, count)| count == 3)
}

pub(super) fn read(source: Source) -> Result<Points> {
    let builder = PointsBuilder::new(&source.path, false);
    let mut reader = Reader { source, line: Vec::new(), builder, scans: 0 };
    while reader.advance()? {
        reader.read_scan()?;
        reader.scans += 1;
    }
    let cloud = reader.builder.cloud();
    cloud.unit = Some(LengthUnit::Metre);
    cloud.notes.push(Note::MetresByCustom);
    reader.builder.finish()
}

struct Reader {
    source: Source,
    line: Vec<u8>,
    builder: PointsBuilder,
    /// How many scans were read.
    scans: u64,
}

impl Reader {
    /// Goes to the next line that is not empty, if there is one.
    fn advance(&mut self) -> Result<bool> {
        while self.source.next_text_line(&mut self.line)? {
            if !matches!(self.line.trim_ascii(), b"" | b"\x1a") {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Reads the scan whose first line is the one at hand.
    fn read_scan(&mut self) -> Result<()> {
        let columns = self.size("columns")?;
        self.advance_in_head()?;
        let rows = self.size("rows")?;
        let Some(count) = columns.checked_mul(rows) else {
            return Err(self.source.error("has a scan with too many cells", EXPORT_AGAIN));
        };
        let end = self.read_placement()?;
        self.builder.begin_scan(true);
        self.read_cells(count)?;
        let shape = usize::try_from(rows).ok().zip(usize::try_from(columns).ok());
        let shape = shape.filter(|&(rows, columns)| rows > 1 && columns > 1);
        let grid = shape.map(|(rows, columns)| GridShape { rows, columns, order: Order::Columns });
        self.builder.end_scan(ScanEnd { grid, ..end })
    }

    fn size(&self, what: &str) -> Result<u64> {
        integer(self.line.trim_ascii()).ok_or_else(|| {
            let text = excerpt(&self.line);
            let what = format!("has \u{201c}{text}\u{201d} for the number of {what} of a scan");
            self.source.error(what, EXPORT_AGAIN)
        })
    }

    fn advance_in_head(&mut self) -> Result<()> {
        if self.advance()? {
            return Ok(());
        }
        let what = format!("ends in the header of scan {}", self.scans);
        Err(Error::new(&self.source.path, what, EXPORT_AGAIN))
    }

    /// Reads where the scanner stood and how the scan is placed.
    fn read_placement(&mut self) -> Result<ScanEnd> {
        let position = self.head_row::<3>()?;
        // The axes say again what the matrix says.
        for _ in 0..3 {
            self.head_row::<3>()?;
        }
        let mut matrix = [[0.0; 4]; 4];
        for row in &mut matrix {
            *row = self.head_row::<4>()?;
        }
        let [x, y, z, translation] = matrix.map(|[x, y, z, _]| [x, y, z]);
        let pose = Pose { axes: [x, y, z], translation };
        if matrix.map(|row| row[3]) != [0.0, 0.0, 0.0, 1.0] || is_flat(&pose) {
            let what = format!("has a matrix that places nothing for scan {}", self.scans);
            return Err(self.source.error(what, EXPORT_AGAIN));
        }
        // Some programs place the points themselves and leave the matrix empty.
        let viewpoint = if translation == [0.0; 3] { position } else { translation };
        Ok(ScanEnd { viewpoint: Some(viewpoint), pose: Some(pose), grid: None })
    }

    fn head_row<const N: usize>(&mut self) -> Result<[f64; N]> {
        self.advance_in_head()?;
        let row = numbers::<N>(&self.line).filter(|(_, count)| *count == N);
        let row = row.map(|(row, _)| row).filter(|row| row.iter().all(|x| x.is_finite()));
        row.ok_or_else(|| {
            let text = excerpt(&self.line);
            let what =
                format!("has \u{201c}{text}\u{201d} in a header where {N} numbers should be");
            self.source.error(what, number_help(&text))
        })
    }

    fn read_cells(&mut self, count: u64) -> Result<()> {
        let mut found = [0; 2];
        for i in 0..count {
            if !self.advance()? {
                let what = format!("ends after {i} of the {count} cells of scan {}", self.scans);
                let error = Error::new(&self.source.path, what, EXPORT_AGAIN);
                return Err(error.at(Location::Element("cell", i)));
            }
            let cell = numbers::<3>(&self.line).filter(|(_, count)| matches!(count, 3 | 4 | 6 | 7));
            let Some((xyz, columns)) = cell else {
                let text = excerpt(&self.line);
                let what = format!("has an unreadable point \u{201c}{text}\u{201d}");
                return Err(self.source.error(what, number_help(&text)));
            };
            match xyz == [0.0; 3] {
                true => self.builder.leave_out(LeftOut::Nothing)?,
                false => {
                    found[0] += u64::from(matches!(columns, 4 | 7));
                    found[1] += u64::from(columns >= 6);
                    self.builder.push(xyz, [0.0; 3])?;
                }
            }
        }
        let lost = &mut self.builder.cloud().lost;
        lost.intensities += found[0];
        lost.colours += found[1];
        Ok(())
    }
}

/// Whether the axes of `pose` lie in a plane.
fn is_flat(pose: &Pose) -> bool {
    let [a, b, c] = pose.axes;
    let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0]);
    let lengths = pose.axes.map(|axis| axis.iter().map(|x| x * x).sum::<f64>().sqrt());
    let most: f64 = lengths.iter().product();
    // Also where the numbers are too large for a product.
    !(volume.abs() > FLAT * most && most.is_finite())
}

/// The first `N` numbers of a line, and how many words it has.
fn numbers<const N: usize>(line: &[u8]) -> Option<([f64; N], usize)> {
    let mut numbers = [0.0; N];
    let mut count = 0;
    for word in line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
        if let Some(number) = numbers.get_mut(count) {
            let word = std::str::from_utf8(word).ok()?;
            *number = word.parse().ok().or_else(|| plain_number(word).parse().ok())?;
        }
        count += 1;
    }
    (count >= N).then_some((numbers, count))
}

fn integer(text: &[u8]) -> Option<u64> {
    std::str::from_utf8(text).ok()?.parse().ok()
}
