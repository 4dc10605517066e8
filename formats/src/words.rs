//! Counts in the messages of both crates.

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

#[cfg(test)]
mod tests {
    use super::{grouped, plural};

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
