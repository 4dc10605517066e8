//! The limits of what is read: the 32-bit indices of a [`Soup`](crate::Soup), and the number of
//! compressed points.

use std::path::Path;

use crate::words::plural;
use crate::{Error, Result, Soup};

/// Checks that `points` more points and `corners` more corners fit into `soup`.
pub(crate) fn check_room(path: &Path, soup: &Soup, points: u64, corners: u64) -> Result<()> {
    let most = soup.points.len() as u64 + points;
    let most = most.max(soup.polygons.corner_count() as u64 + corners);
    if most <= u64::from(u32::MAX) {
        return Ok(());
    }
    let help = "Decimate the scan or cut it into parts.";
    Err(Error::new(path, "has more than four billion points or corners", help))
}

/// A byte of compressed points holds at most so many points. Real scans take a byte or more for
/// a point. Equal points take next to nothing, and could fill any memory.
const MOST_IN_A_BYTE: u64 = 8;

/// The number of points that are always allowed. They take 48 MiB.
const FREE_POINTS: u64 = 2 << 20;

/// Checks that `points` may be in `bytes` bytes.
pub(crate) fn check_density(path: &Path, points: u64, bytes: usize) -> Result<()> {
    if points <= FREE_POINTS.max((bytes as u64).saturating_mul(MOST_IN_A_BYTE)) {
        return Ok(());
    }
    let what = format!("announces {} in {}", plural(points, "point"), plural(bytes, "byte"));
    Err(Error::new(path, what, "If this is right, save it again without compression."))
}
