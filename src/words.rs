//! Figures as people read them.

use crate::Conversion;

/// A length in mm with four significant digits, for people: scans are as large as
/// a mountain and, with the wrong unit, as small as a grain.
pub fn mm(length: f64) -> String {
    let digits = if length > 0.0 { 3 - length.log10().floor() as i32 } else { 0 };
    format!("{length:.*} mm", digits.clamp(0, 12) as usize)
}

impl Conversion {
    /// How many points, and how much of the face, are beyond the tolerance, and the worst.
    pub fn beyond(&self) -> String {
        let (tolerance, place) =
            (mm(self.tolerance), |[x, y, z]: [f64; 3]| format!("({x:.3}, {y:.3}, {z:.3})"));
        let mut parts = Vec::new();
        if self.missed.points > 0 {
            parts.push(format!(
                "{} of {} points are farther than {tolerance} from the face; the worst, {}, at {}",
                self.missed.points,
                self.fit_deviation.distances.len(),
                mm(self.missed.worst),
                place(self.missed.worst_at),
            ));
        }
        let back = &self.face_to_scan;
        if self.tolerance_named && back.beyond > 0 {
            parts.push(format!(
                "the face is farther than {tolerance} and their chord error from {} of {} triangles; the worst, {}, at {}",
                back.beyond,
                back.triangles,
                mm(back.max),
                place(back.max_at),
            ));
        }
        parts.join(", and ")
    }
}

#[cfg(test)]
mod tests {
    use super::mm;

    #[test]
    fn lengths_have_four_digits() {
        assert_eq!(mm(0.059712), "0.05971 mm");
        assert_eq!(mm(22.532185), "22.53 mm");
        assert_eq!(mm(53468.6), "53469 mm");
        assert_eq!(mm(0.0), "0 mm");
        assert_eq!(mm(1.2345e-5), "0.00001234 mm");
    }
}
