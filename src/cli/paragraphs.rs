//! Text in lines that fit on a terminal.

use scan2step::words::printable;

/// The width of a usual terminal, less one column.
const WIDTH: usize = 79;

/// A line divided at blanks so that it fits on a usual terminal. All lines but the first are indented.
/// A word that is too long, as a path may be, keeps its line.
/// What would control a terminal is escaped.
pub(crate) fn wrapped(line: &str, indent: usize) -> String {
    let line = &*printable(line);
    let mut text = String::new();
    let mut column = 0;
    for (number, word) in line.split(' ').enumerate() {
        let length = word.chars().count();
        let separator = usize::from(number > 0);
        if column > indent && column + separator + length > WIDTH {
            text.push('\n');
            text.extend(std::iter::repeat_n(' ', indent));
            column = indent;
        } else if separator > 0 {
            text.push(' ');
            column += 1;
        }
        text += word;
        column += length;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn lines_are_divided_at_blanks() {
        assert_eq!(wrapped("  a  short line", 4), "  a  short line");
        let long = format!("  label  {}", "word ".repeat(30).trim_end());
        let text = wrapped(&long, 9);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3, "{text}");
        assert!(lines.iter().all(|line| line.chars().count() <= 79), "{text}");
        assert!(lines[1..].iter().all(|line| line.starts_with("         word")), "{text}");
        assert_eq!(text.split_whitespace().count(), 31);
        let path = "x".repeat(200);
        assert_eq!(wrapped(&path, 4), path);
    }
}
