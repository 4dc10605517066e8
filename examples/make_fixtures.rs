//! Writes the fixtures, which are virtual scans with known true surfaces.
//!
//! cargo run --example make_fixtures

use std::fs::File;
use std::io::{self, BufWriter};
use std::path::Path;

#[path = "../tests/common/virtual_scan.rs"]
#[allow(dead_code)]
mod virtual_scan;

fn main() -> io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let create = |name: &str| File::create(folder.join(name)).map(BufWriter::new);
    virtual_scan::relief_scan().write_ply(&mut create("relief.ply")?)?;
    virtual_scan::relief_scan().write_xyz(&mut create("relief.xyz")?)?;
    virtual_scan::rolled_scan().write_obj(&mut create("rolled_sheet.obj")?)?;
    virtual_scan::ring_scan().write_obj(&mut create("ring.obj")?)
}
