//! Numbers in the notations of mesh exporters.

use std::borrow::Cow;

/// Converts `token` to a notation that both Rust and ply-rs read. There are digits on both sides of
/// the point. NaN or infinity in any notation becomes a number that is too large for a double, so
/// that it is read as infinity. (ply-rs does not know `nan`, and later stages treat all non-finite
/// points in the same way.) A token that is not a number is returned unchanged.
pub(crate) fn plain_number(token: &str) -> Cow<'_, str> {
    let digits = token.trim_start_matches(['+', '-']);
    let starts = digits.as_bytes().first().copied().unwrap_or(0);
    if starts.is_ascii_alphabetic() || digits.contains('#') {
        return non_finite(token, digits);
    }
    let open = digits.ends_with('.') || digits.contains(".e") || digits.contains(".E");
    if starts != b'.' && !open {
        return Cow::Borrowed(token);
    }
    let sign = &token[..token.len() - digits.len()];
    let zero = if starts == b'.' { "0" } else { "" };
    let (mantissa, exponent) = digits.split_at(digits.find(['e', 'E']).unwrap_or(digits.len()));
    // A point without digits is not a number.
    if !mantissa.contains(|c: char| c.is_ascii_digit()) {
        return Cow::Borrowed(token);
    }
    let tail = if mantissa.ends_with('.') { "0" } else { "" };
    Cow::Owned(format!("{sign}{zero}{mantissa}{tail}{exponent}"))
}

fn non_finite<'a>(token: &'a str, digits: &str) -> Cow<'a, str> {
    let word = digits.to_ascii_lowercase();
    // "1.#QNAN" and similar words come from Microsoft's libraries.
    let known = ["nan", "inf", "1.#ind", "1.#inf", "1.#qnan", "1.#snan"];
    match known.iter().any(|k| word.starts_with(k)) {
        true if token.starts_with('-') => Cow::Borrowed("-1e999"),
        true => Cow::Borrowed("1e999"),
        false => Cow::Borrowed(token),
    }
}

/// The advice for text that should be a number.
pub(crate) fn number_help(text: &str) -> &'static str {
    if text.contains(',') {
        "Export again with decimal points instead of decimal commas."
    } else {
        crate::source::EXPORT_AGAIN
    }
}

/// The beginning of `text` as short printable text for an error.
pub(crate) fn excerpt(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(&text[..text.len().min(160)]).into_owned();
    let clean: String = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if clean.chars().count() <= 40 {
        return clean;
    }
    clean.chars().take(39).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::plain_number;

    #[test]
    fn numbers_get_digits_on_both_sides() {
        for (from, to) in [
            (".5", "0.5"),
            ("-.5", "-0.5"),
            ("5.", "5.0"),
            ("+5.e-3", "+5.0e-3"),
            (".5e", "0.5e"),
            (".", "."),
            ("-.", "-."),
            (".e5", ".e5"),
            ("1e5", "1e5"),
            ("-nan(0x8)", "-1e999"),
            ("1.#QNAN", "1e999"),
            ("Infinity", "1e999"),
            ("five", "five"),
            ("", ""),
        ] {
            assert_eq!(plain_number(from), to);
        }
    }
}
