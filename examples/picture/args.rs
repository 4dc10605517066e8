//! The command line of the example.

use std::path::PathBuf;

use clap::{Parser, ValueEnum};

/// Makes a PNG that shows a scan beside the CAD face that it becomes.
#[derive(Debug, Parser)]
#[command(name = "picture")]
pub struct Args {
    /// The scan: .ply, .obj, .gltf, .glb or .stl, each also gzipped
    pub scan: PathBuf,
    /// The picture to write
    #[arg(value_name = "OUT.png", value_parser = png_file)]
    pub out: PathBuf,
    /// Width and height in pixels [default: as the mode needs]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[usize; 2]>,
    /// What to show
    #[arg(long, value_enum, default_value_t = Mode::Pair)]
    pub mode: Mode,
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Mode {
    /// The measured mesh beside the trimmed face
    Pair,
    /// The measured mesh, coloured by its distance from the face
    Deviation,
    /// The control net over the face
    Net,
    /// The parameter plane: mesh, knot lines and trim loops
    Uv,
    /// The measured mesh with its boundary loops
    Mesh,
    /// The mesh around a hole, as measured and smoothed
    Smooth,
    /// A filled hole
    Fill,
    /// The mesh in the parameter plane
    Map,
    /// The face around a hole, and the rim
    Trim,
    /// The layout of quads of a closed scan
    Layout,
    /// The faces of the solid that a closed scan becomes
    Faces,
}

impl Args {
    /// The given size, or a size that suits the mode.
    pub fn size(&self) -> [usize; 2] {
        self.size.unwrap_or(match self.mode {
            Mode::Pair | Mode::Smooth => [1600, 800],
            Mode::Uv | Mode::Map => [1000, 1000],
            _ => [1200, 1000],
        })
    }
}

/// The allowed sides in pixels. They give a legible picture and a frame buffer of at most 2 GB.
const SIDES: std::ops::RangeInclusive<usize> = 160..=4096;

fn size(text: &str) -> Result<[usize; 2], String> {
    let side = |s: &str| {
        let n: usize = s.parse().map_err(|_| "not of the form 1600x800".to_string())?;
        let (least, most) = (SIDES.start(), SIDES.end());
        if SIDES.contains(&n) { Ok(n) } else { Err(format!("sides are {least} to {most} pixels")) }
    };
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or("not of the form 1600x800")?;
    Ok([side(width)?, side(height)?])
}

fn png_file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("png") => Ok(path),
        _ => Err("not .png".into()),
    }
}
