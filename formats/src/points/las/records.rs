//! The points of a LAS file as bytes of 11 formats, of which the first 17 bytes matter.
//!
//! The input is records as the LAS specification 1.4 R15 lays them out. The valid ones go
//! to a [`PointsBuilder`].

use std::io::Read;

use las::{Transform, Vector};

use super::header::LasHeader;
use crate::Result;
use crate::points::{LeftOut, PointsBuilder, ReadOptions};
use crate::source::Source;

/// The classes of noise: low points and high noise.
const NOISE: [u8; 2] = [7, 18];

/// Points are read in blocks of so many bytes. A larger block takes more memory and is not
/// quicker.
const BLOCK: usize = 1 << 18;

/// Takes the records of points.
pub(super) struct LasPoints {
    pub(super) builder: PointsBuilder,
    transforms: Vector<Transform>,
    is_extended: bool,
    options: ReadOptions,
    /// The number of kept points with an intensity.
    pub(super) intensities: u64,
}

impl LasPoints {
    pub(super) fn new(builder: PointsBuilder, header: &LasHeader, options: &ReadOptions) -> Self {
        LasPoints {
            builder,
            transforms: header.transforms,
            is_extended: header.format.is_extended,
            options: options.clone(),
            intensities: 0,
        }
    }

    /// Takes one record, which has the length of its format.
    pub(super) fn push(&mut self, record: &[u8]) -> Result<()> {
        let (flags, class) = (record[15], record[16]);
        let (is_withheld, class) = match self.is_extended {
            true => (flags & 4 != 0, class),
            false => (flags & 0x80 != 0, flags & 0x1f),
        };
        let intensity = u16::from_le_bytes([record[12], record[13]]);
        if let Some(why) = self.left_out(is_withheld, class, intensity) {
            return self.builder.leave_out(why);
        }
        self.intensities += u64::from(intensity != 0);
        let number = |at: usize| {
            i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
        };
        let Vector { x, y, z } = self.transforms;
        let xyz = [x.direct(number(0)), y.direct(number(4)), z.direct(number(8))];
        self.builder.push(xyz, [0.0; 3])
    }

    fn left_out(&self, is_withheld: bool, class: u8, intensity: u16) -> Option<LeftOut> {
        let wanted = &self.options.classes;
        let is_noise = NOISE.contains(&class) && !wanted.contains(&class);
        let is_other = !wanted.is_empty() && !wanted.contains(&class);
        let is_dark = self.options.min_intensity.is_some_and(|least| f64::from(intensity) < least);
        match (is_withheld, is_noise, is_other || is_dark) {
            (true, _, _) => Some(LeftOut::Marked),
            (_, true, _) => Some(LeftOut::Noise),
            (_, _, true) => Some(LeftOut::Filtered),
            _ => None,
        }
    }

    /// Takes the points of a file that is not compressed. Returns their number, which is less
    /// than the header's where the file is cut.
    pub(super) fn read_plain(&mut self, source: &mut Source, header: &LasHeader) -> Result<u64> {
        let most = (BLOCK / header.record).max(1) as u64;
        let mut bytes = Vec::new();
        let mut found = 0;
        while found < header.announced {
            let count = most.min(header.announced - found);
            bytes.clear();
            let block = (&mut source.stream).take(count * header.record as u64);
            { block }.read_to_end(&mut bytes).map_err(|e| source.io_error(&e))?;
            for record in bytes.chunks_exact(header.record) {
                self.push(record)?;
                found += 1;
            }
            if bytes.len() < count as usize * header.record {
                break;
            }
        }
        Ok(found)
    }
}
