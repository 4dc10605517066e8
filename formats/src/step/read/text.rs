//! Decoding of strings (ISO 10303-21, clause 6.4.3).

/// The characters of a string without escapes.
pub(super) fn decoded(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text).replace("''", "'").replace(['\r', '\n'], "");
    let mut out = String::new();
    let mut rest = text.as_str();
    while let Some(i) = rest.find('\\') {
        out.push_str(&rest[..i]);
        let (read, used) = escape(&rest[i..]);
        out.push_str(&read);
        rest = &rest[i + used..];
    }
    out + rest
}

/// The characters and the length of the escape at the beginning of `text`.
fn escape(text: &str) -> (String, usize) {
    let wide = |width: usize| {
        let (digits, _) = text[4..].split_once("\\X0\\")?;
        let code = |d: &[u8]| u16::from_str_radix(std::str::from_utf8(d).ok()?, 16).ok();
        let read = if width == 4 {
            let units: Option<Vec<u16>> = digits.as_bytes().chunks(4).map(code).collect();
            String::from_utf16_lossy(&units?)
        } else {
            let each = digits.as_bytes().chunks(8).map(|d| {
                let number = u32::from_str_radix(std::str::from_utf8(d).ok()?, 16).ok()?;
                char::from_u32(number)
            });
            each.collect::<Option<String>>()?
        };
        Some((read, 4 + digits.len() + 4))
    };
    let latin = |from: usize| {
        let number = u8::from_str_radix(text.get(from..from + 2)?, 16).ok()?;
        Some((char::from(number).to_string(), from + 2))
    };
    let found = match text.as_bytes() {
        [b'\\', b'\\', ..] => Some(("\\".to_owned(), 2)),
        [b'\\', b'X', b'2', b'\\', ..] => wide(4),
        [b'\\', b'X', b'4', b'\\', ..] => wide(8),
        [b'\\', b'X', b'\\', ..] => latin(3),
        [b'\\', b'S', b'\\', c, ..] if c.is_ascii() => Some((char::from(c | 0x80).to_string(), 4)),
        _ => None,
    };
    found.unwrap_or_else(|| ("\\".to_owned(), 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strings_are_unescaped() {
        for (escaped, plain) in [
            (r"a''b\\c", r"a'b\c"),
            (r"Gr\X2\00F600DF\X0\e", "Größe"),
            (r"\X2\00E9\X0\\X4\0001F600\X0\", "é😀"),
            (r"\X2\D83DDE00\X0\", "😀"),
            (r"\X\E9\S\i", "éé"),
            (r"\X2\00zz\X0\", r"\X2\00zz\X0\"),
            (r"\X2\00", r"\X2\00"),
            ("\\", "\\"),
        ] {
            assert_eq!(decoded(escaped.as_bytes()), plain, "{escaped}");
        }
    }
}
