//! Writes the seeds: `corpus/<target>/<name>` in the folder of this crate.

use std::fs;
use std::io;
use std::path::Path;

use scan2step_formats_fuzz::seeds;

fn main() -> io::Result<()> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for (name, content) in seeds::all() {
        let target = match name.rsplit_once('.') {
            Some((_, "gz")) => "gzip",
            Some((_, extension)) => extension,
            None => continue,
        };
        let folder = corpus.join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(name), content)?;
    }
    Ok(())
}
