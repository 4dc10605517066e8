//! `--stages DIR`: a file of what each stage made.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use scan2step::Stage;
use scan2step::geometry::{Uv, VertexId};
use scan2step::mesh::{Bound, FaceOrigin, Mesh, Patch, QuadMesh, RawPoints};
use scan2step::spline::{KnotVector, Surface};
use scan2step::stages::trim::TrimLoop;
use serde_json::json;

use super::output::{self, Pending};
use super::temp_files;

/// The names of the files.
const NAMES: [&str; 7] = [
    "0-points.ply",
    "1-mesh.ply",
    "2-smooth.ply",
    "3-filled.ply",
    "4-parameterized.ply",
    "4-layout.ply",
    "5-surface.json",
];

/// Writes the stages' files under temporary names, until the run puts all its files in place.
pub(crate) struct Stages {
    folder: PathBuf,
    pub pending: Vec<Pending>,
}

impl Stages {
    /// Writes into `folder`, which is made if it does not exist.
    pub(super) fn new(folder: &Path) -> Result<Self, formats::Error> {
        temp_files::folder(folder).map_err(|e| {
            let help = "name a folder that can be made and written to";
            formats::Error::new(folder, format!("cannot be made: {e}"), help)
        })?;
        NAMES.iter().try_for_each(|name| output::check_replaces_no_input(&folder.join(name)))?;
        Ok(Stages { folder: folder.to_owned(), pending: Vec::new() })
    }

    /// Continues in a folder of its own for one of several components.
    pub(super) fn component(&mut self, root: &Path, number: usize) -> Result<(), formats::Error> {
        let of_component = Stages::new(&root.join(format!("component-{number}")))?;
        self.folder = of_component.folder;
        Ok(())
    }

    /// Writes what a stage made, if it has a file.
    pub(super) fn write(&mut self, stage: &Stage) -> Result<(), formats::Error> {
        match stage {
            Stage::Mesh(disk) => self.put("1-mesh.ply", |out| mesh(out, &disk.mesh)),
            Stage::Smooth(disk) => self.put("2-smooth.ply", |out| mesh(out, &disk.mesh)),
            Stage::Fill(p) => self.put("3-filled.ply", |out| patch(out, p, None)),
            Stage::Parameterize(map, _) => {
                self.put("4-parameterized.ply", |out| patch(out, &map.patch, Some(&map.uv)))
            }
            Stage::Layout(mesh) => self.put("4-layout.ply", |out| quads(out, mesh)),
            Stage::Trim(face, loops) => self.put("5-surface.json", |out| surface(out, face, loops)),
            _ => Ok(()),
        }
    }

    /// Writes the points that a mesh was made of. The mesh has so many `mm` to its unit.
    pub(crate) fn points(&mut self, raw: &RawPoints, mm: f64) -> Result<(), formats::Error> {
        self.put("0-points.ply", |out| {
            vertex_header(out, raw.all().count(), &["uchar used"])?;
            writeln!(out, "end_header")?;
            raw.all().try_for_each(|(p, is_used)| {
                doubles(out, (mm * p.coords).as_slice())?;
                out.write_all(&[u8::from(is_used)])
            })
        })
    }

    fn put(
        &mut self,
        name: &str,
        content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), formats::Error> {
        self.pending.push(output::write(&self.folder.join(name), content)?);
        Ok(())
    }
}

/// The beginning of a header, up to the properties of vertices.
fn vertex_header(out: &mut dyn Write, count: usize, properties: &[&str]) -> io::Result<()> {
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment scan2step, millimetres")?;
    writeln!(out, "element vertex {count}")?;
    let mut all = ["double x", "double y", "double z"].iter().chain(properties);
    all.try_for_each(|property| writeln!(out, "property {property}"))
}

fn header(out: &mut dyn Write, vertex: (usize, &[&str]), face: (usize, &[&str])) -> io::Result<()> {
    vertex_header(out, vertex.0, vertex.1)?;
    writeln!(out, "element face {}", face.0)?;
    for property in ["list uchar int vertex_indices"].iter().chain(face.1) {
        writeln!(out, "property {property}")?;
    }
    writeln!(out, "end_header")
}

fn doubles(out: &mut dyn Write, numbers: &[f64]) -> io::Result<()> {
    numbers.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

fn triangle(out: &mut dyn Write, t: &[VertexId; 3]) -> io::Result<()> {
    out.write_all(&[3])?;
    t.iter().try_for_each(|v| out.write_all(&(v.0 as i32).to_le_bytes()))
}

fn mesh(out: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    header(out, (mesh.points.len(), &[]), (mesh.triangles.len(), &[]))?;
    mesh.points.iter().try_for_each(|p| doubles(out, p.coords.as_slice()))?;
    mesh.triangles.iter().try_for_each(|t| triangle(out, t))
}

/// A quad mesh, with the block of each quad.
fn quads(out: &mut dyn Write, mesh: &QuadMesh) -> io::Result<()> {
    header(out, (mesh.points.len(), &[]), (mesh.quads.len(), &["int patch"]))?;
    mesh.points.iter().try_for_each(|p| doubles(out, p.coords.as_slice()))?;
    for (number, quad) in mesh.quads.iter().enumerate() {
        out.write_all(&[4])?;
        quad.iter().try_for_each(|v| out.write_all(&(v.0 as i32).to_le_bytes()))?;
        out.write_all(&((number / mesh.side.pow(2)) as i32).to_le_bytes())?;
    }
    Ok(())
}

fn patch(out: &mut dyn Write, patch: &Patch, uv: Option<&[Uv]>) -> io::Result<()> {
    let mesh = &patch.mesh;
    let with_uv = ["uchar origin", "double u", "double v"];
    let properties = if uv.is_some() { &with_uv[..] } else { &with_uv[..1] };
    header(out, (mesh.points.len(), properties), (mesh.triangles.len(), &["int hole"]))?;
    for (i, p) in mesh.points.iter().enumerate() {
        doubles(out, p.coords.as_slice())?;
        out.write_all(&[u8::from(!patch.is_measured(VertexId::from(i)))])?;
        if let Some(uv) = uv {
            doubles(out, uv[i].coords.as_slice())?;
        }
    }
    for (t, origin) in mesh.triangles.iter().zip(&patch.origin) {
        triangle(out, t)?;
        let hole = match origin {
            FaceOrigin::Measured => -1,
            FaceOrigin::Hole(hole) => *hole as i32,
            FaceOrigin::Bay => -2,
        };
        out.write_all(&hole.to_le_bytes())?;
    }
    Ok(())
}

fn knots(k: &KnotVector) -> serde_json::Value {
    json!(k.knots())
}

fn surface(out: &mut dyn Write, surface: &Surface, loops: &[TrimLoop]) -> io::Result<()> {
    let nv = surface.v.functions();
    let net: Vec<Vec<[f64; 3]>> =
        surface.net.chunks(nv).map(|row| row.iter().map(|p| (*p).into()).collect()).collect();
    let trim_loops: Vec<_> = loops
        .iter()
        .map(|l| {
            let pcurves: Vec<_> = l
                .pcurves
                .iter()
                .map(|c| {
                    let points: Vec<[f64; 2]> = c.control.iter().map(|p| (*p).into()).collect();
                    json!({ "degree": c.knots.degree(), "knots": knots(&c.knots), "points": points })
                })
                .collect();
            json!({
                "outer": l.of == Bound::Outer, "hole": l.of.hole(), "island": l.of.island(),
                "within": l.within, "pcurves": pcurves,
            })
        })
        .collect();
    let whole = json!({
        "degree": [surface.u.degree(), surface.v.degree()],
        "knots_u": knots(&surface.u),
        "knots_v": knots(&surface.v),
        "net": net,
        "trim_loops": trim_loops,
    });
    serde_json::to_writer(&mut *out, &whole)?;
    writeln!(out)
}
