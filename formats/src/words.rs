//! Counts and names in the messages of both crates.

use std::borrow::Cow;

/// Counts above this have their digits in groups of three. Shorter ones are read at a glance.
const UNGROUPED: u64 = 9999;

/// A count as people write it: "4000", "39,312".
pub fn grouped(count: impl TryInto<u64>) -> String {
    let count = count.try_into().unwrap_or(u64::MAX);
    let digits = count.to_string();
    if count <= UNGROUPED {
        return digits;
    }
    let first = (digits.len() + 2) % 3 + 1;
    let mut text = digits[..first].to_owned();
    for group in digits.as_bytes()[first..].as_chunks::<3>().0 {
        text.push(',');
        text.extend(group.iter().map(|&digit| char::from(digit)));
    }
    text
}

/// A count of things by their name: "1 hole", "2 holes", "3 vertices".
pub fn plural(count: impl TryInto<u64>, name: &str) -> String {
    let count = count.try_into().unwrap_or(u64::MAX);
    let number = grouped(count);
    match (name.strip_suffix("ex"), name.strip_suffix("us")) {
        _ if count == 1 => format!("{number} {name}"),
        (Some(stem), _) => format!("{number} {stem}ices"),
        (_, Some(stem)) => format!("{number} {stem}i"),
        _ => format!("{number} {name}s"),
    }
}

/// Text of one line as terminals and pages may show it. A name from a file may hold characters that control a terminal,
/// end the line, or turn the direction of what follows. They are written as in JSON: `\u001b`.
pub fn printable(text: &str) -> Cow<'_, str> {
    escaped(text, is_hidden)
}

/// The same for a text of several lines.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| is_hidden(c) && c != '\n')
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut clean = String::with_capacity(text.len());
    for c in text.chars() {
        match is_escaped(c) {
            true => clean += &format!("\\u{:04x}", u32::from(c)),
            false => clean.push(c),
        }
    }
    Cow::Owned(clean)
}

/// Whether a character controls what shows it and has no shape of its own.
fn is_hidden(c: char) -> bool {
    let is_direction = |c| matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    c.is_control() || is_direction(c) || matches!(c, '\u{2028}' | '\u{2029}')
}

#[cfg(test)]
mod tests {
    use super::{grouped, plural, printable, printable_lines};

    #[test]
    fn what_controls_a_terminal_is_escaped() {
        assert_eq!(printable("Größe é😀 \u{a0}"), "Größe é😀 \u{a0}");
        assert_eq!(
            printable("a\u{1b}[31m\u{7}\n\u{9b}b\u{202e}"),
            "a\\u001b[31m\\u0007\\u000a\\u009bb\\u202e"
        );
        assert_eq!(printable_lines("a\n\r"), "a\n\\u000d");
    }

    #[test]
    fn one_thing_is_no_plural() {
        assert_eq!([0_u32, 1, 2].map(|n| plural(n, "hole")), ["0 holes", "1 hole", "2 holes"]);
        assert_eq!([1_u64, 2].map(|n| plural(n, "torus")), ["1 torus", "2 tori"]);
        assert_eq!([1_u64, 20_000].map(|n| plural(n, "vertex")), ["1 vertex", "20,000 vertices"]);
    }

    #[test]
    fn large_counts_have_groups_of_digits() {
        let counts = [0_usize, 999, 9999, 10_000, 123_456, 1_234_567];
        assert_eq!(counts.map(grouped), ["0", "999", "9999", "10,000", "123,456", "1,234,567"]);
    }
}
