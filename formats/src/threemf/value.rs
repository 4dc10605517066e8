//! The values of attributes.

use super::fault::PackageFault;
use crate::scene::Placement;
use crate::token::{excerpt, number_help};

/// A finite number.
pub(super) fn number(text: &str) -> Result<f64, PackageFault> {
    let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| {
        let shown = excerpt(text.as_bytes());
        PackageFault::helped(
            format!("has \u{201c}{shown}\u{201d} where a number should be"),
            number_help(text),
        )
    })
}

/// A whole number from 0 on.
pub(super) fn index(text: &str) -> Result<u32, PackageFault> {
    let digits = text.trim();
    let index = digits.bytes().all(|b| b.is_ascii_digit()).then(|| digits.parse().ok()).flatten();
    index.ok_or_else(|| {
        let shown = excerpt(text.as_bytes());
        PackageFault::new(format!("has \u{201c}{shown}\u{201d} where a whole number should be"))
    })
}

/// The number of a resource: from 1 to 2^31 - 1.
pub(super) fn resource(text: &str) -> Result<u32, PackageFault> {
    let id = index(text)?;
    let is_valid = (1..=i32::MAX as u32).contains(&id);
    is_valid
        .then_some(id)
        .ok_or_else(|| PackageFault::new(format!("has a resource with the number {id}")))
}

/// A transform: the rows of a matrix that is applied to row vectors, so that they are the images of the axes, then that of
/// the origin.
pub(super) fn transform(text: &str) -> Result<Placement, PackageFault> {
    let numbers = text.split_ascii_whitespace().take(13).map(number);
    let numbers = numbers.collect::<Result<Vec<f64>, PackageFault>>()?;
    let Ok(m) = <[f64; 12]>::try_from(numbers) else {
        return Err(PackageFault::new("has a transform that does not have 12 numbers"));
    };
    let row = |at: usize| [m[at], m[at + 1], m[at + 2]];
    let placement = Placement { axes: [row(0), row(3), row(6)], translation: row(9) };
    match placement.is_flat() {
        false => Ok(placement),
        true => Err(PackageFault::new("has a transform that makes everything flat")),
    }
}

#[cfg(test)]
mod tests {
    use super::{index, number, resource, transform};

    #[test]
    fn only_numbers_are_numbers() {
        assert_eq!(number(" -1.5e3 ").unwrap(), -1500.0);
        assert_eq!(number("+.5").unwrap(), 0.5);
        for text in ["", "abc", "1,5", "NaN", "inf", "1e400", "1 2", "0x1"] {
            assert!(number(text).is_err(), "{text}");
        }
        assert_eq!(index("4294967295").unwrap(), u32::MAX);
        for text in ["", "-1", "+1", "1.0", "4294967296", "1e3", "x"] {
            assert!(index(text).is_err(), "{text}");
        }
        assert!(resource("0").is_err() && resource("2147483648").is_err());
    }

    #[test]
    fn transforms_have_twelve_numbers() {
        let moved = transform("0 1 0 -1 0 0 0 0 1 5 6 7").unwrap();
        assert_eq!(moved.apply([1.0, 0.0, 0.0]), [5.0, 7.0, 7.0]);
        for text in
            ["", "1 0 0 0 1 0 0 0 1 0 0", "1 0 0 0 1 0 0 0 1 0 0 0 0", "0 0 0 0 0 0 0 0 0 0 0 0"]
        {
            assert!(transform(text).is_err(), "{text}");
        }
    }
}
