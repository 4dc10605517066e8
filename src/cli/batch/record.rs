//! The result of one scan as a small file of its own. Shards that run at the same time share no
//! file, and a run that is stopped loses only the scan that it is converting.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use formats::Format;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::scans::FoundScan;
use crate::cli::output::{self, Pending};

/// The folder of records in the output folder.
pub(crate) const FOLDER: &str = ".scan2step";

/// The result of one scan.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Record {
    pub scan2step: String,
    pub file: String,
    pub input: Stamp,
    pub options: Vec<String>,
    /// The exit code of `convert`.
    pub exit_code: i32,
    pub seconds: f64,
    #[serde(flatten)]
    pub figures: Figures,
    pub hints: Vec<String>,
    pub error: Option<String>,
    pub help: Option<String>,
    pub outputs: Vec<Output>,
}

/// How well a scan was converted. For several components these are the largest values.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Figures {
    /// What the scan became: "face", "shell" or "solid".
    pub shape: Option<String>,
    /// The number of faces of solids and shells, or of components that became a face each.
    pub faces: Option<u64>,
    /// Control points of each component.
    pub net: Vec<[u64; 2]>,
    pub rms_mm: Option<f64>,
    pub max_mm: Option<f64>,
    pub tolerance_mm: Option<f64>,
    /// Holes cut out.
    pub holes: Option<usize>,
    /// The unit of the scan's numbers, and whether it was assumed.
    pub units: Option<String>,
    pub units_assumed: Option<bool>,
}

/// A file that was written, and where in the output folder.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Output {
    pub file: String,
    pub bytes: u64,
    pub sha256: String,
}

/// What identifies the content of a scan.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Stamp {
    bytes: u64,
    /// The time of the last change, since 1970; `None` if the scan has other files besides.
    modified_ns: Option<u128>,
    sha256: String,
}

impl Stamp {
    /// The stamp of a scan that can be read.
    pub(super) fn of(scan: &Path) -> Option<Stamp> {
        let meta = std::fs::metadata(scan).ok()?;
        let is_alone = !has_buffers(scan) && materials(scan).is_empty();
        let modified_ns = is_alone.then(|| modified_ns(&meta)).flatten();
        Some(Stamp { bytes: meta.len(), modified_ns, sha256: content(scan)? })
    }

    /// Whether the scan is unchanged. Its content is read only if its time differs.
    fn holds(&self, scan: &Path) -> bool {
        let Ok(meta) = std::fs::metadata(scan) else { return false };
        let untouched = self.modified_ns.is_some() && self.modified_ns == modified_ns(&meta);
        meta.len() == self.bytes && (untouched || content(scan).as_ref() == Some(&self.sha256))
    }
}

fn modified_ns(meta: &std::fs::Metadata) -> Option<u128> {
    let since = meta.modified().ok()?.duration_since(SystemTime::UNIX_EPOCH).ok()?;
    Some(since.as_nanos())
}

/// Whether the scan may have its numbers in other files, as glTF does.
fn has_buffers(scan: &Path) -> bool {
    matches!(Format::by_extension(scan), Some(Format::Gltf | Format::Glb))
}

/// The files of materials that an OBJ names, which are beside it.
fn materials(scan: &Path) -> Vec<PathBuf> {
    if Format::by_extension(scan) != Some(Format::Obj) {
        return Vec::new();
    }
    let Ok(file) = File::open(scan) else { return Vec::new() };
    let lines = BufReader::new(file).split(b'\n').map_while(Result::ok);
    let names = lines.filter_map(|line| {
        let name = line.trim_ascii_start().strip_prefix(b"mtllib")?.trim_ascii();
        Some(scan.with_file_name(String::from_utf8_lossy(name).as_ref()))
    });
    names.collect()
}

/// A hash of the scan's content, other files included.
fn content(scan: &Path) -> Option<String> {
    if !has_buffers(scan) {
        let (_, own) = hash_of(scan).ok()?;
        let materials = materials(scan);
        if materials.is_empty() {
            return Some(own);
        }
        // A file of materials that is missing is one, too.
        let each =
            materials.iter().map(|file| hash_of(file).map_or(String::new(), |(_, hash)| hash));
        let all: String = std::iter::once(own).chain(each).collect();
        return Some(output::hexadecimal(&Sha256::digest(all)));
    }
    let scene = formats::read_scene(scan).ok()?;
    let mut hash = Sha256::new();
    for mesh in scene.meshes() {
        let soup = &mesh.soup;
        soup.points.iter().flatten().for_each(|x| hash.update(x.to_le_bytes()));
        for polygon in soup.polygons.iter() {
            hash.update((polygon.len() as u64).to_le_bytes());
            polygon.iter().for_each(|corner| hash.update(corner.to_le_bytes()));
        }
        hash.update(format!("{:?} {:?} {:?}", mesh.name, mesh.colour, mesh.colours));
    }
    hash.update(format!("{:?} {:?} {:?}", scene.unit, scene.nodes(), scene.forms()));
    Some(output::hexadecimal(&hash.finalize()))
}

fn hash_of(path: &Path) -> io::Result<(u64, String)> {
    let mut hash = Sha256::new();
    let bytes = io::copy(&mut File::open(path)?, &mut hash)?;
    Ok((bytes, output::hexadecimal(&hash.finalize())))
}

impl Output {
    /// A file that was written into `out`.
    pub(super) fn of(out: &Path, file: &Path) -> io::Result<Output> {
        let (bytes, sha256) = hash_of(&out.join(file))?;
        Ok(Output { file: file.display().to_string(), bytes, sha256 })
    }
}

impl Figures {
    /// The figures in the report of `convert`.
    pub(super) fn of(report: &Value) -> Figures {
        // An assembly has parts, and a scan may have several components.
        let several = ["parts", "components"].iter().find_map(|key| report.get(key)?.as_array());
        let parts = match several {
            Some(parts) => parts.iter().collect(),
            None => vec![report],
        };
        let worst = |at: &str| {
            let values = parts.iter().filter_map(|part| part.pointer(at)?.as_f64());
            values.reduce(f64::max)
        };
        let side = |part: &Value, k: usize| part.pointer(&format!("/fit/net/{k}"))?.as_u64();
        let cut = |part: &&Value| -> Option<usize> {
            let holes = part.pointer("/fill/holes")?.as_array()?;
            Some(holes.iter().filter(|hole| hole["trimmed"] == true).count())
        };
        let kind = |part: &Value| part["shape"]["kind"].as_str().unwrap_or("face").to_owned();
        let faces = |part: &&Value| part.pointer("/shape/faces").map_or(Some(1), Value::as_u64);
        Figures {
            shape: parts.first().map(|part| kind(part)),
            faces: parts.iter().map(faces).sum(),
            net: parts.iter().filter_map(|p| Some([side(p, 0)?, side(p, 1)?])).collect(),
            rms_mm: worst("/fit/rms_mm"),
            max_mm: worst("/fit/max_mm"),
            tolerance_mm: worst("/tolerance_mm"),
            holes: parts.iter().map(cut).sum(),
            units: report.pointer("/input/units").and_then(Value::as_str).map(str::to_owned),
            units_assumed: report.pointer("/input/units_assumed").and_then(Value::as_bool),
        }
    }
}

/// The path of a record about a scan. Scans in different folders can have the same name, so a
/// hash of the whole name distinguishes them.
pub(crate) fn path(out: &Path, scan: &FoundScan, extension: &str) -> PathBuf {
    let key = output::hexadecimal(&Sha256::digest(scan.name.as_os_str().as_encoded_bytes()));
    out.join(FOLDER).join(format!("{}.{extension}", &key[..32]))
}

impl Record {
    /// The record of an earlier run, if there is one.
    pub(crate) fn read(out: &Path, scan: &FoundScan) -> Option<Record> {
        let text = std::fs::read(path(out, scan, "json")).ok()?;
        // If it cannot be read, the scan is converted again.
        serde_json::from_slice(&text).ok()
    }

    /// Writes the record.
    pub(super) fn write(&self, out: &Path, scan: &FoundScan) -> Result<(), formats::Error> {
        let file = output::write(&path(out, scan, "json"), |to| {
            serde_json::to_writer_pretty(&mut *to, self)?;
            writeln!(to)
        })?;
        Pending::publish(vec![file])
    }

    /// Whether the scan need not be converted again: the files are there, and scan, options and
    /// program are the same.
    pub(crate) fn holds(&self, out: &Path, scan: &FoundScan, options: &[String]) -> bool {
        let there = |output: &Output| {
            let meta = std::fs::metadata(out.join(&output.file));
            meta.is_ok_and(|meta| meta.is_file() && meta.len() == output.bytes)
        };
        matches!(self.exit_code, 0 | 3)
            && self.scan2step == env!("CARGO_PKG_VERSION")
            && self.options == options
            && self.outputs.iter().all(there)
            && self.input.holds(&scan.path)
    }
}
