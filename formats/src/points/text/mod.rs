//! Columns of text: XYZ, TXT, ASC, CSV and PTS.
//!
//! These files have no header that a reader could trust. What separates the
//! numbers, whether commas are decimal ones, and which columns hold what is
//! decided by the first lines. Lines of another kind are counted, and too many
//! of them are an error.

mod dialect;
mod layout;
mod numbering;
mod unit;

use self::dialect::Dialect;
use self::layout::{FirstRows, Layout};
use super::{Columns, Note, Points, PointsBuilder, ScanEnd, degrees};
use crate::source::Source;
use crate::token::{excerpt, number_help};
use crate::unit_comment::UnitComments;
use crate::words::{grouped, plural};
use crate::{LengthUnit, Location, Result};

/// So many lines of numbers decide what the columns hold.
const SAMPLE: usize = 100;

/// A file of which more than one line in so many is unreadable is refused: it is
/// something else, or damaged.
const MOST_UNREADABLE: u64 = 100;

/// Whether `head` is text with a line that can be a point.
pub(super) fn is_points(head: &[u8]) -> bool {
    is_text(head) && Shape::of(head).is_some()
}

pub(super) fn is_text(head: &[u8]) -> bool {
    !head.iter().any(|b| b.is_ascii_control() && !b.is_ascii_whitespace() && *b != 0x1a)
}

/// Whether `head` begins with the number of points, as PTS does.
pub(super) fn has_count(head: &[u8]) -> bool {
    let line = lines(head).find(|line| !is_comment(line)).unwrap_or_default();
    is_text(head) && count(line).is_some()
}

/// Reads columns of text, perhaps those that the user chose. With `is_pts` their unit is the metre.
pub(super) fn read(mut source: Source, is_pts: bool, chosen: Option<&Columns>) -> Result<Points> {
    if !is_text(&source.head) {
        let help = "Export the points as plain text, or as PLY or PCD.";
        return Err(source.error("is binary, but its name means a text file", help));
    }
    let Some(mut shape) = Shape::of(&source.head) else {
        return Err(no_points(&mut source)?);
    };
    if let Some(columns) = chosen {
        let names = shape.names.as_deref();
        let layout = Layout::chosen(columns, names, shape.layout.count);
        let help = "Columns are counted from 1: the first three are x, y and z, and three more are the normal.";
        shape.layout = layout.map_err(|what| crate::Error::new(&source.path, what, help))?;
    }
    if shape.mixes_commas {
        let help = "Export again with decimal points, or with semicolons between the columns.";
        return Err(source.error("seems to have commas between and within its numbers", help));
    }
    let mut builder = PointsBuilder::new(&source.path, shape.layout.normal.is_some());
    builder.begin_scan(false);
    let mut rows = TextRows { source, shape, builder, counts: Counts::default() };
    rows.read()?;
    rows.finish(is_pts, chosen.is_some())
}

fn no_points(source: &mut Source) -> Result<crate::Error> {
    let mut line = Vec::new();
    while source.next_text_line(&mut line)? && (line.trim_ascii().is_empty() || is_comment(&line)) {
    }
    let text = excerpt(&line);
    let what = format!("has no line with three numbers, but \u{201c}{text}\u{201d}");
    Ok(source.error(what, number_help(&text)))
}

/// How the numbers of a file are written, and in which columns.
struct Shape {
    dialect: Dialect,
    layout: Layout,
    /// The names of the columns, if there is a line of as many names.
    names: Option<Vec<String>>,
    /// The unit that the header names.
    unit: Option<LengthUnit>,
    /// The unit that a comment names, and the comment.
    comment: Option<(LengthUnit, String)>,
    /// Whether the columns cannot be told, because commas mean two things.
    mixes_commas: bool,
}

impl Shape {
    /// The shape of the file that begins with `head`. `None` if no line of `head`
    /// is a point.
    fn of(head: &[u8]) -> Option<Shape> {
        let end = head.iter().rposition(|b| matches!(b, b'\r' | b'\n'));
        // The last line of a head may be cut.
        let whole = end.filter(|&end| lines(&head[..end]).any(is_numbers));
        let head = &head[..whole.unwrap_or(head.len())];
        let numbers = lines(head).filter(|line| is_numbers(line)).take(SAMPLE);
        let dialect = Dialect::of(numbers.clone());
        let mut rows: Vec<Vec<&[u8]>> =
            numbers.clone().map(|line| dialect.fields(line).collect()).collect();
        rows.retain(|row| row.len() >= 3);
        let count = usual_length(&rows)?;
        rows.retain(|row| row.len() == count);
        let values = rows
            .iter()
            .map(|row| row.iter().map(|field| dialect.number(field)).collect())
            .collect();
        let rows = FirstRows { fields: rows, numbers: values };
        let before = lines(head).take_while(|line| !is_numbers(line));
        let mut comments = UnitComments::default();
        lines(head).filter(|line| is_comment(line)).for_each(|line| comments.read(line));
        let unit = before.clone().find_map(unit::of_header);
        let doubled = before.clone().filter_map(|line| Layout::by_names(&names(line)));
        let doubled = doubled.filter(|layout| 2 * layout.count == count).count() > 0;
        let mixes_commas = dialect.mixes_commas(numbers) || doubled && dialect.has_comma_columns();
        let named = before.flat_map(|line| [names(line), dialect.names(line)]);
        let named: Vec<Vec<String>> = named.filter(|names| names.len() == count).collect();
        let mut layouts = named.iter().filter_map(|names| Some((names, Layout::by_names(names)?)));
        let (names, layout) = match layouts.next_back() {
            Some((names, layout)) => (Some(names.clone()), layout),
            None => {
                let names = named.last();
                (names.cloned(), Layout::by_custom(&rows, names.map(Vec::as_slice))?)
            }
        };
        let comment = comments.unit().filter(|_| unit.is_none());
        Some(Shape { dialect, layout, names, unit, comment, mixes_commas })
    }

    /// The position and the normal in a line.
    fn point(&self, line: &[u8]) -> Option<[[f64; 3]; 2]> {
        let mut point = [[0.0; 3]; 2];
        let mut count = 0;
        for (i, field) in self.dialect.fields(line).enumerate() {
            count += 1;
            if let Some(axis) = self.layout.position.iter().position(|&column| column == i) {
                point[0][axis] = self.dialect.number(field)?;
            }
            let normal = self.layout.normal.iter().flatten().position(|&column| column == i);
            if let Some(axis) = normal {
                point[1][axis] = self.dialect.number(field)?;
            }
        }
        (count == self.layout.count).then_some(point)
    }
}

/// The most frequent number of columns; of several the least.
fn usual_length(rows: &[Vec<&[u8]>]) -> Option<usize> {
    let frequency = |length: usize| rows.iter().filter(|row| row.len() == length).count();
    let lengths = rows.iter().map(Vec::len);
    lengths.max_by_key(|&length| (frequency(length), std::cmp::Reverse(length)))
}

/// How many lines of each kind there were.
#[derive(Default)]
struct Counts {
    points: u64,
    unreadable: u64,
    /// The first unreadable line: its number and what it says.
    first: Option<(u64, String)>,
    /// The number of points that the file announces.
    announced: Option<u64>,
    last_is_cut: bool,
}

struct TextRows {
    source: Source,
    shape: Shape,
    builder: PointsBuilder,
    counts: Counts,
}

impl TextRows {
    fn read(&mut self) -> Result<()> {
        let mut line = Vec::new();
        while self.source.next_text_line(&mut line)? {
            let text = line.trim_ascii();
            if text.is_empty() || text == b"\x1a" || is_comment(text) {
                continue;
            }
            match self.shape.point(text) {
                Some([xyz, normal]) if !self.is_cut() => {
                    self.counts.points += 1;
                    self.builder.push(xyz, normal)?;
                }
                _ => self.read_other(text),
            }
        }
        Ok(())
    }

    /// Whether the last number of the line at hand may be cut: the line has no
    /// end, and the file should have more points.
    fn is_cut(&self) -> bool {
        let due = self.counts.announced.is_some_and(|n| self.counts.points + 1 < n);
        due && !self.source.ended_line
    }

    /// Reads a line that is no point.
    fn read_other(&mut self, text: &[u8]) {
        if !self.source.ended_line && self.counts.points > 0 {
            self.counts.last_is_cut = true;
        } else if let Some(count) = count(text) {
            // PTS may have several blocks.
            let announced = self.counts.announced.unwrap_or(0);
            self.counts.announced = Some(announced.saturating_add(count));
        } else if self.counts.points > 0 || !is_header(text) {
            self.counts.unreadable += 1;
            self.counts.first.get_or_insert_with(|| (self.source.line, excerpt(text)));
        }
    }

    fn finish(mut self, is_pts: bool, is_chosen: bool) -> Result<Points> {
        self.check_unreadable()?;
        if self.has_degrees() {
            return Err(degrees::refusal(&self.source.path));
        }
        let counts = &self.counts;
        let cloud = self.builder.cloud();
        cloud.lost.unreadable_lines = counts.unreadable + u64::from(counts.last_is_cut);
        let others = self.shape.layout.others.iter().map(String::as_str);
        cloud.lost.count(others, counts.points);
        let (of_comment, comment) = self.shape.comment.unzip();
        let unit = self.shape.unit.or(of_comment);
        let may_be_times = !is_chosen && self.shape.names.is_none() && self.shape.layout.count > 3;
        let may_be_times = may_be_times
            && self.shape.layout.position[0] == 0
            && cloud.normals.is_none()
            && cloud.len() >= numbering::LEAST_ROWS
            && cloud.positions.is_sorted_by(|a, b| a[0] < b[0]);
        let by_custom = is_pts && unit.is_none();
        cloud.unit = unit.or(by_custom.then_some(LengthUnit::Metre));
        let found = counts.points;
        let count = counts.announced.filter(|&announced| announced != found);
        let notes = [
            by_custom.then_some(Note::MetresByCustom),
            comment.map(|comment| Note::UnitByComment { comment }),
            match self.shape.layout.numbering {
                0 => None,
                columns => Some(Note::PointNumbers { columns }),
            },
            self.shape.dialect.decimal_commas.then_some(Note::DecimalCommas),
            may_be_times.then_some(Note::FirstColumnRises),
            count.map(|announced| Note::CountDiffers { announced, found }),
            counts.last_is_cut.then_some(Note::LastLineCut),
        ];
        cloud.notes.extend(notes.into_iter().flatten());
        self.builder.end_scan(ScanEnd::default())?;
        self.builder.finish()
    }

    /// Whether x and y are degrees, by their names or by their digits.
    fn has_degrees(&mut self) -> bool {
        let Shape { names, layout, unit, comment, .. } = &self.shape;
        if unit.is_some() || comment.is_some() {
            return false;
        }
        let positions = &self.builder.cloud().positions;
        let axis = |column| layout.position.iter().position(|&at| at == column);
        let named = names.as_deref().and_then(degrees::named);
        match named.map(|columns| columns.map(axis)) {
            Some([Some(longitude), Some(latitude)]) => {
                degrees::are_in_range(positions, [longitude, latitude])
            }
            _ => degrees::are_told_by_digits(positions),
        }
    }

    /// Refuses a file with too many lines that are no points.
    fn check_unreadable(&self) -> Result<()> {
        let Counts { points, unreadable, first, .. } = &self.counts;
        let lines = points + unreadable;
        let Some((line, text)) = first.as_ref().filter(|_| unreadable * MOST_UNREADABLE > lines)
        else {
            return Ok(());
        };
        let what = format!(
            "has {} of {} that are no points, first \u{201c}{text}\u{201d}",
            grouped(*unreadable),
            plural(lines, "line")
        );
        let help = match text.contains(',') {
            true => number_help(text),
            false => "Each line must have the same columns of numbers: export it again.",
        };
        Err(self.source.error(what, help).at(Location::Line(*line)))
    }
}

fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> + Clone {
    let lines = text.split(|b| matches!(b, b'\r' | b'\n')).map(<[u8]>::trim_ascii);
    lines.map(|line| line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line)).filter(|l| !l.is_empty())
}

/// The only number of a line, if it is an integer.
fn count(line: &[u8]) -> Option<u64> {
    std::str::from_utf8(line.trim_ascii()).ok()?.parse().ok()
}

fn is_comment(line: &[u8]) -> bool {
    let line = line.trim_ascii();
    [&b"#"[..], b"//", b"%", b"!"].iter().any(|mark| line.starts_with(mark))
}

/// Whether a line before the first point can be a header.
fn is_header(line: &[u8]) -> bool {
    line.iter().any(u8::is_ascii_alphabetic) && !is_numbers(line)
}

/// The words of a line, without the mark of a comment and without units.
fn names(line: &[u8]) -> Vec<String> {
    let names = words(unmarked(line)).filter(|word| !matches!(word[0], b'[' | b'('));
    names.map(|name| String::from_utf8_lossy(name).into_owned()).collect()
}

/// A line without the mark of a comment.
fn unmarked(line: &[u8]) -> &[u8] {
    let start = line.iter().position(|b| !matches!(b, b'#' | b'/' | b'%' | b'!'));
    &line[start.unwrap_or(line.len())..]
}

/// Whether a line has three or more numbers, whatever separates them.
fn is_numbers(line: &[u8]) -> bool {
    let point = Dialect::of(std::iter::empty());
    let numbers = words(line).filter(|word| point.number(word).is_some());
    !is_comment(line) && numbers.take(3).count() == 3
}

/// What stands between any separators of a line.
fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let separates = |b: &u8| b.is_ascii_whitespace() || matches!(b, b',' | b';' | b'|' | b'"');
    line.split(separates).filter(|word| !word.is_empty())
}
