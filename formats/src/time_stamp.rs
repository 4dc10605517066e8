//! ISO 8601 time stamps for formats with other notations.

/// The year, month, day, hour, minute and second of an ISO 8601 time stamp. Missing fields are
/// those of 1970-01-01T00:00:00.
pub(crate) fn fields(time_stamp: &str) -> [u32; 6] {
    let mut fields = [1970, 1, 1, 0, 0, 0];
    let numbers = time_stamp.split(|c: char| !c.is_ascii_digit()).filter(|s| !s.is_empty());
    for (field, digits) in fields.iter_mut().zip(numbers) {
        *field = digits.parse().unwrap_or(*field);
    }
    fields
}
