//! Parts in UTF-16, which XML allows.

use std::io::{self, Read};

/// The order of the bytes of a character.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum ByteOrder {
    Little,
    Big,
}

/// The order of bytes of text that begins so. `None` if it is not UTF-16.
pub(super) fn order(head: &[u8]) -> Option<ByteOrder> {
    match head {
        [0xff, 0xfe, ..] | [b'<', 0, ..] => Some(ByteOrder::Little),
        [0xfe, 0xff, ..] | [0, b'<', ..] => Some(ByteOrder::Big),
        _ => None,
    }
}

/// Reads all of the text as UTF-8.
pub(super) fn read(mut from: impl Read, order: ByteOrder) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes)?;
    let unit = |pair: &[u8; 2]| match order {
        ByteOrder::Little => u16::from_le_bytes(*pair),
        ByteOrder::Big => u16::from_be_bytes(*pair),
    };
    let (pairs, rest) = bytes.as_chunks::<2>();
    let unsound = || io::Error::other("it is not valid UTF-16 text");
    if !rest.is_empty() {
        return Err(unsound());
    }
    let mut text = String::new();
    for character in char::decode_utf16(pairs.iter().map(unit)) {
        text.push(character.map_err(|_| unsound())?);
    }
    let text = text.trim_start_matches('\u{feff}');
    // The declaration would still say that the text is UTF-16.
    let body = text.strip_prefix("<?xml").and_then(|rest| rest.split_once("?>"));
    Ok(body.map_or(text, |(_, body)| body).as_bytes().to_vec())
}

#[cfg(test)]
mod tests {
    use super::{ByteOrder, order, read};

    #[test]
    fn both_orders_are_read() {
        let text = "<?xml version=\"1.0\" encoding=\"UTF-16\"?><a b=\"\u{fc}\u{1f600}\"/>";
        let units = || std::iter::once(0xfeff).chain(text.encode_utf16());
        let little: Vec<u8> = units().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = units().flat_map(u16::to_be_bytes).collect();
        for (bytes, expected) in [(&little, ByteOrder::Little), (&big, ByteOrder::Big)] {
            assert_eq!(order(bytes), Some(expected));
            let read = read(bytes.as_slice(), expected).unwrap();
            assert_eq!(String::from_utf8(read).unwrap(), "<a b=\"\u{fc}\u{1f600}\"/>");
        }
        assert!(read(&little[..9], ByteOrder::Little).is_err());
        assert_eq!(order(b"<?xml"), None);
    }
}
