//! The header of a PCD file: lines of a keyword and values, the last is `DATA`.

use super::value::{Kind, Slot};
use crate::source::{EXPORT_AGAIN, Source};
use crate::token::excerpt;
use crate::{Error, Result};

/// Bounds far above any real header, so that a hostile one costs nothing.
const MAX_LINES: u64 = 1000;
const MAX_LINE: usize = 1 << 16;

/// No point is longer: PCL's longest descriptors take 8 KiB.
const MAX_RECORD: u64 = 1 << 16;

/// How the points are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary,
    Compressed,
}

/// What the header announces.
pub(super) struct PcdHeader {
    pub(super) encoding: Encoding,
    pub(super) fields: Vec<Field>,
    pub(super) points: u64,
    pub(super) width: u64,
    pub(super) height: u64,
    /// Where the scanner stood, if the header says so.
    pub(super) viewpoint: Option<[f64; 3]>,
}

/// One or more values of a point under one name.
pub(super) struct Field {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// How many values the field has.
    pub(super) count: u64,
}

impl Field {
    /// The bytes of the field in a binary record.
    pub(super) fn bytes(&self) -> u64 {
        self.count.saturating_mul(self.kind.bytes() as u64)
    }
}

impl PcdHeader {
    /// The bytes of a binary record.
    pub(super) fn record(&self) -> usize {
        // At most `MAX_RECORD`.
        self.fields.iter().map(Field::bytes).sum::<u64>() as usize
    }

    /// Whether the points are pixels of an image.
    pub(super) fn is_organised(&self) -> bool {
        self.width > 1 && self.height > 1
    }

    /// Where the three fields of these names are in a record.
    pub(super) fn slots(&self, names: [&str; 3]) -> Option<[Slot; 3]> {
        let slot = |name: &str| {
            let at = self.fields.iter().position(|field| field.name == name)?;
            let before = &self.fields[..at];
            let Field { kind, count, .. } = self.fields[at];
            (count == 1).then_some(Slot {
                kind,
                offset: before.iter().map(Field::bytes).sum::<u64>() as usize,
                column: before.iter().map(|field| field.count).sum::<u64>() as usize,
            })
        };
        let [x, y, z] = names.map(slot);
        Some([x?, y?, z?])
    }
}

/// Reads up to and with the `DATA` line, and not a byte further.
pub(super) fn read(source: &mut Source) -> Result<PcdHeader> {
    let mut lines = HeaderLines::default();
    let mut line = Vec::new();
    loop {
        if !source.next_line(&mut line)? {
            return Err(bad(source, "no DATA line in its header"));
        }
        if source.line > MAX_LINES || line.len() > MAX_LINE {
            return Err(bad(source, "an endless header"));
        }
        let text = String::from_utf8_lossy(&line);
        let mut words = text.split_ascii_whitespace();
        let Some(keyword) = words.next().filter(|word| !word.starts_with('#')) else { continue };
        if keyword == "DATA" {
            let encoding = match words.next() {
                Some("ascii") => Encoding::Ascii,
                Some("binary") => Encoding::Binary,
                Some("binary_compressed") => Encoding::Compressed,
                _ => return Err(bad(source, "data of an unknown encoding")),
            };
            return lines.header(source, encoding);
        }
        lines.set(source, keyword, words)?;
    }
}

/// The values of the lines.
#[derive(Default)]
struct HeaderLines {
    fields: Vec<String>,
    sizes: Vec<String>,
    types: Vec<String>,
    counts: Vec<String>,
    width: Option<u64>,
    height: Option<u64>,
    points: Option<u64>,
    viewpoint: Option<[f64; 3]>,
}

impl HeaderLines {
    fn set<'a>(
        &mut self,
        source: &Source,
        keyword: &str,
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<()> {
        match keyword {
            "VERSION" => {}
            "FIELDS" | "COLUMNS" => self.fields = words.map(str::to_owned).collect(),
            "SIZE" => self.sizes = words.map(str::to_owned).collect(),
            "TYPE" => self.types = words.map(str::to_owned).collect(),
            "COUNT" => self.counts = words.map(str::to_owned).collect(),
            "WIDTH" => self.width = Some(number(source, words.next())?),
            "HEIGHT" => self.height = Some(number(source, words.next())?),
            "POINTS" => self.points = Some(number(source, words.next())?),
            "VIEWPOINT" => self.viewpoint = viewpoint(words),
            _ => {
                let word = excerpt(keyword.as_bytes());
                return Err(bad(
                    source,
                    &format!("the unknown header line \u{201c}{word}\u{201d}"),
                ));
            }
        }
        Ok(())
    }

    fn header(mut self, source: &Source, encoding: Encoding) -> Result<PcdHeader> {
        let fields = self.checked_fields(source)?;
        let record = fields.iter().fold(0, |sum: u64, field| sum.saturating_add(field.bytes()));
        if record > MAX_RECORD {
            return Err(bad(source, &format!("points of {record} bytes")));
        }
        let (width, height) = (self.width.unwrap_or(0), self.height.unwrap_or(1));
        let points = self.points.or_else(|| width.checked_mul(height));
        let points = points.ok_or_else(|| bad(source, "too many points"))?;
        let viewpoint = self.viewpoint.take();
        Ok(PcdHeader { encoding, fields, points, width, height, viewpoint })
    }

    fn checked_fields(&self, source: &Source) -> Result<Vec<Field>> {
        let count = self.fields.len();
        if count == 0 {
            return Err(bad(source, "no FIELDS line in its header"));
        }
        // Version 0.5 may leave out COUNT.
        let counts_fit = self.counts.is_empty() || self.counts.len() == count;
        if self.sizes.len() != count || self.types.len() != count || !counts_fit {
            return Err(bad(source, "lines of SIZE, TYPE and COUNT that do not match its FIELDS"));
        }
        let mut fields = Vec::new();
        for (i, name) in self.fields.iter().enumerate() {
            let (size, letter) = (&self.sizes[i], &self.types[i]);
            let kind = Kind::of(letter, size).ok_or_else(|| {
                let [name, letter, size] = [name, letter, size].map(|s| excerpt(s.as_bytes()));
                bad(source, &format!("the field {name} of type {letter} and size {size}"))
            })?;
            let count = number(source, self.counts.get(i).map_or(Some("1"), |c| Some(c)))?;
            fields.push(Field { name: name.clone(), kind, count });
        }
        Ok(fields)
    }
}

fn bad(source: &Source, what: &str) -> Error {
    source.error(format!("has {what}"), EXPORT_AGAIN)
}

fn number(source: &Source, word: Option<&str>) -> Result<u64> {
    let word = word.unwrap_or_default();
    word.parse().map_err(|_| {
        bad(
            source,
            &format!("a header with the number \u{201c}{}\u{201d}", excerpt(word.as_bytes())),
        )
    })
}

/// The position in the seven numbers of a `VIEWPOINT` line. Its orientation is
/// not needed, for the points are in the frame of the position.
fn viewpoint<'a>(words: impl Iterator<Item = &'a str>) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = words.take(3).map_while(|word| word.parse().ok()).collect();
    let position = <[f64; 3]>::try_from(numbers).ok()?;
    position.iter().all(|x| x.is_finite()).then_some(position)
}
