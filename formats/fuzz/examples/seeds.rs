//! Writes the seeds: `corpus/<target>/<name>` in the folder of this crate.

use std::fs;
use std::io;
use std::path::Path;

use scan2step_formats_fuzz::{cloud_seeds, seeds};

fn main() -> io::Result<()> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let clouds = cloud_seeds::all().into_iter().map(|(name, content)| (name, content, true));
    let meshes = seeds::all().into_iter().map(|(name, content)| (name, content, false));
    for (name, content, is_cloud) in meshes.chain(clouds) {
        let target = match name.rsplit_once('.') {
            Some((_, "gz")) => "gzip",
            Some((_, "ply")) if is_cloud => "cloud_ply",
            Some((_, "csv" | "txt" | "asc")) => "xyz",
            Some((_, extension)) => extension,
            None => continue,
        };
        let folder = corpus.join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), content)?;
    }
    let folder = corpus.join("threemf");
    fs::create_dir_all(&folder)?;
    fs::write(folder.join("parts.model"), seeds::MODEL)
}
