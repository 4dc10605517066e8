//! Names that people and programs give.

/// The most characters of a name. CAD programs show about 30 of them, and a name of a megabyte is no name.
const MOST_CHARACTERS: usize = 256;

/// A name without control characters and white space around it, cut to a length that people read. `None` if nothing remains.
pub(crate) fn clean_name(name: &str) -> Option<String> {
    let is_odd = |c: char| {
        c.is_control()
            || matches!(c, '\u{200e}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
    };
    let mut characters = name.trim().chars().map(|c| if is_odd(c) { ' ' } else { c });
    let mut clean: String = characters.clone().take(MOST_CHARACTERS).collect();
    if characters.nth(MOST_CHARACTERS).is_some() {
        clean.pop();
        clean.push('\u{2026}');
    }
    let clean = clean.trim();
    (!clean.is_empty()).then(|| clean.to_owned())
}

#[cfg(test)]
mod tests {
    use super::{MOST_CHARACTERS, clean_name};

    #[test]
    fn names_are_short_and_printable() {
        for (name, clean) in [
            ("Größe", Some("Größe")),
            ("  a\tb\n", Some("a b")),
            ("a');#1=B", Some("a');#1=B")),
            ("\u{202e}gpj.exe", Some("gpj.exe")),
            (" ", None),
            ("", None),
        ] {
            assert_eq!(clean_name(name).as_deref(), clean);
        }
        let long = clean_name(&"ä".repeat(1 << 20)).unwrap_or_default();
        assert_eq!(long.chars().count(), MOST_CHARACTERS);
        assert!(long.ends_with('…'));
    }
}
