//! Marc Lehmann's LZF compression, of which only unpacking is needed.

/// One packed byte unpacks to at most so many bytes: three of them repeat up to 264.
const MOST_GROWTH: usize = 264 / 3;

/// Unpacks `packed` to exactly `length` bytes. `None` if it unpacks to another
/// number of bytes or refers to bytes before its beginning.
///
/// Memory grows with what is unpacked, whatever `length` says.
pub(super) fn unpack(packed: &[u8], length: usize) -> Option<Vec<u8>> {
    if length > packed.len().saturating_mul(MOST_GROWTH) {
        return None;
    }
    let mut out: Vec<u8> = Vec::new();
    let mut rest = packed;
    while let Some((&control, after)) = rest.split_first() {
        rest = after;
        let control = usize::from(control);
        if control < 32 {
            let (literal, after) = rest.split_at_checked(control + 1)?;
            out.extend_from_slice(literal);
            rest = after;
        } else {
            let mut count = control >> 5;
            if count == 7 {
                count += usize::from(*rest.split_off_first()?);
            }
            let low = usize::from(*rest.split_off_first()?);
            let back = ((control & 31) << 8 | low) + 1;
            repeat(&mut out, back, count + 2)?;
        }
        if out.len() > length {
            return None;
        }
    }
    (out.len() == length).then_some(out)
}

/// Appends `count` bytes from `back` bytes before the end. They may reach into
/// what is appended.
fn repeat(out: &mut Vec<u8>, back: usize, count: usize) -> Option<()> {
    let start = out.len().checked_sub(back)?;
    if back >= count {
        out.extend_from_within(start..start + count);
        return Some(());
    }
    for i in start..start + count {
        let byte = *out.get(i)?;
        out.push(byte);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::unpack;

    #[test]
    fn literals_and_repeats_unpack() {
        // "ab", then 7 bytes from two back, then one literal.
        let packed = [1, b'a', b'b', 5 << 5, 1, 0, b'!'];
        assert_eq!(unpack(&packed, 10).as_deref(), Some(&b"ababababa!"[..]));
        // A long repeat: 7 + 255 + 2 bytes from one back.
        assert_eq!(unpack(&[0, b'x', 7 << 5, 255, 0], 265), Some(vec![b'x'; 265]));
        assert_eq!(unpack(&[], 0), Some(Vec::new()));
    }

    #[test]
    fn damage_is_refused() {
        for (packed, length) in [
            (&[1, b'a', b'b'][..], 3),  // too short
            (&[1, b'a', b'b'], 1),      // too long
            (&[3, b'a', b'b'], 4),      // the literal is cut
            (&[0, b'a', 1 << 5], 4),    // the distance is cut
            (&[0, b'a', 7 << 5], 4),    // the length is cut
            (&[0, b'a', 1 << 5, 1], 4), // back before the begin
            (&[0, b'a'], usize::MAX),   // more than can be
        ] {
            assert_eq!(unpack(packed, length), None, "{packed:?}");
        }
    }
}
