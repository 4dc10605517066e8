//! Development only.
use scan2step::geometry::{Point, Vector, VertexId};
use scan2step::mesh::Mesh;
use scan2step::primitives::Primitive;
use scan2step::stages::seams::{self, FacePatch};
use scan2step::stages::sharpen::{Options, ScanSurface, sharpen};
use std::fs;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let bin = fs::read(&args[1]).unwrap();
    let int = |k: usize| i32::from_le_bytes(bin[4 * k..4 * k + 4].try_into().unwrap());
    let (nv, nt) = (int(0) as usize, int(1) as usize);
    let f = |k: usize| f64::from_le_bytes(bin[8 + 8 * k..16 + 8 * k].try_into().unwrap());
    let points: Vec<Point> =
        (0..nv).map(|i| Point::new(f(3 * i), f(3 * i + 1), f(3 * i + 2))).collect();
    let t0 = 2 + 6 * nv;
    let triangles: Vec<[VertexId; 3]> =
        (0..nt).map(|t| [0, 1, 2].map(|k| VertexId(int(t0 + 3 * t + k) as u32))).collect();
    let mesh = Mesh { points, triangles };
    let lab = fs::read(&args[2]).unwrap();
    let lab = |v: usize| i32::from_le_bytes(lab[4 * v..4 * v + 4].try_into().unwrap());
    // lines: sigma feff, then id t cx cy cz ax ay az r R side
    let text = fs::read_to_string(&args[3]).unwrap();
    let mut lines = text.lines();
    let nums =
        |l: &str| l.split_whitespace().map(|x| x.parse::<f64>().unwrap()).collect::<Vec<f64>>();
    let head = nums(lines.next().unwrap());
    let mut surfaces = Vec::new();
    let mut number = std::collections::BTreeMap::new();
    for l in lines {
        let x = nums(l);
        let c = Point::new(x[2], x[3], x[4]);
        let a = Vector::new(x[5], x[6], x[7]);
        let (r, big) = (x[8], x[9]);
        let mut side = x[10];
        let surface = match x[1] as i32 {
            0 => Primitive::Plane { origin: c, normal: a },
            1 => Primitive::Cylinder { origin: c, axis: a, radius: r },
            2 => {
                // dist = ro*cos - h*sin - r, angle = R
                let (axis, angle) = if big < 0.0 { (-a, -big) } else { (a, big) };
                let mut radius = r / angle.cos();
                let mut origin = c;
                if radius <= 0.0 {
                    let h = (1.0 - radius) / angle.tan();
                    origin = c + h * axis;
                    radius = 1.0;
                }
                Primitive::Cone { origin, axis, radius, angle }
            }
            3 => Primitive::Sphere { centre: c, radius: r },
            _ => Primitive::Torus { centre: c, axis: a, major: big, minor: r },
        };
        if let Primitive::Torus { major, minor, .. } = surface {
            if major <= minor {
                continue;
            }
        }
        if side == 0.0 {
            side = 1.0;
        }
        number.insert(x[0] as i32, surfaces.len() as u32);
        surfaces.push(ScanSurface { surface, side });
    }
    let none = u32::MAX;
    let of: Vec<u32> = mesh
        .triangles
        .iter()
        .map(|t| {
            let l = t.map(|v| number.get(&lab(v.index())).copied().unwrap_or(none));
            if l[0] == l[1] || l[0] == l[2] {
                l[0]
            } else if l[1] == l[2] {
                l[1]
            } else {
                let p = Point::from(t.iter().map(|v| mesh.point(*v).coords).sum::<Vector>() / 3.0);
                l.into_iter()
                    .min_by(|a, b| {
                        let d = |r: u32| {
                            if r == none {
                                f64::MAX
                            } else {
                                surfaces[r as usize].surface.distance(p).0.abs()
                            }
                        };
                        d(*a).total_cmp(&d(*b))
                    })
                    .unwrap()
            }
        })
        .collect();
    let start = std::time::Instant::now();
    let made = sharpen(&mesh, &surfaces, &of, &Options { noise: head[0], correlation: head[1] });
    let t1 = start.elapsed().as_secs_f64();
    let none_before = of.iter().filter(|&&r| r == none).count();
    let facets = made.of_triangle.iter().filter(|&&r| r == none).count();
    eprintln!(
        "triangles {nt} regions {} touching {} unlabelled {none_before} -> {facets} lost {} sharpen {t1:.2} s",
        surfaces.len(),
        made.touching,
        made.lost.len()
    );
    let mut why = std::collections::BTreeMap::new();
    for l in &made.lost {
        *why.entry(l.why).or_insert(0) += 1;
    }
    eprintln!("{why:?}");
    let mut patches: Vec<FacePatch> = made
        .surfaces
        .iter()
        .map(|s| FacePatch {
            surface: s.surface,
            side: s.side,
            is_facet: false,
            triangles: Vec::new(),
        })
        .collect();
    for (t, &r) in made.of_triangle.iter().enumerate() {
        if r != none {
            patches[r as usize].triangles.push(t as u32);
        } else {
            let c = made.mesh.triangles[t];
            let n = made.mesh.area_vector(c).normalize();
            patches.push(FacePatch {
                surface: Primitive::Plane { origin: made.mesh.point(c[0]), normal: n },
                side: 1.0,
                is_facet: true,
                triangles: vec![t as u32],
            });
        }
    }
    patches.retain(|p| !p.triangles.is_empty());
    let errors = vec![1e-8; made.mesh.points.len()];
    let options = seams::Options { name: "part".into(), least_exact: 0.0 };
    match seams::solid(&made.mesh, &errors, patches, &options) {
        Ok((brep, report)) => {
            eprintln!(
                "SOLID faces {} facets {} fallbacks {} gap {:.1e} s {:.2}",
                brep.faces.len(),
                report.facets,
                report.fallbacks.len(),
                report.gap,
                start.elapsed().as_secs_f64()
            );
            for f in report.fallbacks.iter().take(12) {
                eprintln!("   {} {} at {:.2?}: {}", f.kind.name(), f.triangles, f.place, f.why);
            }
            let mut out = Vec::new();
            scan2step::formats::step::write(
                &brep,
                &scan2step::formats::step::Options::default(),
                &mut out,
            )
            .unwrap();
            fs::write(&args[4], out).unwrap();
        }
        Err(e) => eprintln!("FAILED {e}"),
    }
}
