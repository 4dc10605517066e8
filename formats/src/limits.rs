//! The limits of a [`Soup`](crate::Soup), which has 32-bit indices.

use std::path::Path;

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
