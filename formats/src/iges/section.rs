//! The directory, parameter and terminate sections (IGES 5.3, clauses 2.2.4.4 to 2.2.4.6).

use std::io;

use super::entity::Entity;
use super::parameters::Parameters;

/// The number of columns for parameters in a line of the parameter section.
const WIDTH: usize = 64;
/// The largest number of seven digits.
const MAX_LINES: usize = 9_999_999;

/// The number of lines that the parameters of each entity take.
pub(super) fn count_lines(entities: &[Entity<'_>]) -> io::Result<Vec<usize>> {
    let mut lines = Vec::with_capacity(entities.len());
    for entity in entities {
        let mut count = 0;
        let mut finish_line = |_: &str| {
            count += 1;
            Ok(())
        };
        entity.compose(Parameters::new(WIDTH, &mut finish_line))?;
        lines.push(count);
    }
    let total: usize = lines.iter().sum();
    if total > MAX_LINES {
        let what = format!("{total} lines, more than an IGES file can number");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, what));
    }
    Ok(lines)
}

/// Writes two lines of ten fields for each entity.
pub(super) fn directory(
    entities: &[Entity<'_>],
    lines: &[usize],
    out: &mut dyn io::Write,
) -> io::Result<()> {
    let mut first_line = 1;
    for (i, (entity, lines)) in entities.iter().zip(lines).enumerate() {
        let (kind, form) = entity.body.kind();
        let (status, label, number) = (entity.status.number(), &entity.label, 2 * i + 1);
        let matrix = entity.matrix.map_or(0, |at| at.0);
        // The fields are type, parameters, structure, line font, level, view, matrix, label
        // display, status.
        writeln!(
            out,
            "{kind:8}{first_line:8}{0:8}{0:8}{0:8}{0:8}{matrix:8}{0:8}{status}D{number:7}",
            0
        )?;
        // The fields are type, line weight, colour, number of parameter lines, form, two reserved
        // ones, label, subscript. There is no subscript, because programs would append it to the
        // label. The negative sign of a colour means that it is a pointer to a definition.
        let next = number + 1;
        let colour = entity.colour.map_or("0".into(), |at| format!("-{at}"));
        writeln!(
            out,
            "{kind:8}{0:8}{colour:>8}{lines:8}{form:8}{1:8}{1:8}{label:>8}{1:8}D{next:7}",
            0, ""
        )?;
        first_line += lines;
    }
    Ok(())
}

/// Writes the parameters. Each line has a pointer back to the directory.
pub(super) fn parameters(entities: &[Entity<'_>], out: &mut dyn io::Write) -> io::Result<()> {
    let mut number = 0;
    for (i, entity) in entities.iter().enumerate() {
        let pointer = 2 * i + 1;
        let mut finish_line = |line: &str| {
            number += 1;
            writeln!(out, "{line:WIDTH$} {pointer:7}P{number:7}")
        };
        entity.compose(Parameters::new(WIDTH, &mut finish_line))?;
    }
    Ok(())
}

/// Writes the last line, which has the number of lines of each section.
pub(super) fn terminate(counts: [usize; 4], out: &mut dyn io::Write) -> io::Result<()> {
    let [s, g, d, p] = counts;
    writeln!(out, "S{s:7}G{g:7}D{d:7}P{p:7}{:40}T{:7}", "", 1)?;
    out.flush() // a buffer that is dropped keeps its errors to itself
}
