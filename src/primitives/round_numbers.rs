//! Numbers that a designer would have chosen.

/// The steps of round numbers, in the unit of the file.
const STEPS: [f64; 13] =
    [10.0, 5.0, 1.0, 0.5, 0.25, 0.1, 0.05, 0.01, 0.005, 0.001, 0.0005, 0.0001, 0.000_01];

/// A round number says something only if chance meets one of its step this rarely.
const CHANCE: f64 = 0.05;

/// The simplest number within a gate that chance does not explain. `unit` is the length of the unit of the value in that of
/// the file.
pub(crate) fn round(value: f64, gate: f64, unit: f64) -> Option<f64> {
    let (x, gate) = (value * unit, gate * unit);
    let steps = STEPS.iter().take_while(|&&step| 2.0 * gate <= CHANCE * step);
    let nearest = steps.map(|step| (x / step).round() * step);
    { nearest }.find(|y| (y - x).abs() <= gate).map(|y| y / unit)
}
