//! Development: fits a network to a quad mesh (text) and a scan.
use std::error::Error;
use std::fs;
use std::time::Instant;

use scan2step::formats::{self, step};
use scan2step::geometry::{Point, VertexId};
use scan2step::mesh::{self, Choice, Components, QuadMesh};
use scan2step::{brep, net, patches};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().collect();
    let text = fs::read_to_string(&args[1])?;
    let mut lines = text.lines();
    let mut next = || lines.next().unwrap().split_whitespace();
    let head: Vec<usize> = next().map(|x| x.parse().unwrap()).collect();
    let mut quads = QuadMesh { side: head[0], ..QuadMesh::default() };
    for _ in 0..head[1] {
        let p: Vec<f64> = next().map(|x| x.parse().unwrap()).collect();
        quads.points.push(Point::new(p[0], p[1], p[2]));
    }
    for _ in 0..head[2] {
        let p: Vec<usize> = next().map(|x| x.parse().unwrap()).collect();
        quads.quads.push([0, 1, 2, 3].map(|k| VertexId::from(p[k])));
    }
    println!("fault {:?} blocks {} euler {}", quads.fault(), quads.blocks(), quads.euler());
    let soup = formats::read_scan(args[2].as_ref())?;
    let scan = Components::new(mesh::from_soup(&soup, 1.0)?);
    let body = scan.take(Choice::default())?.mesh();
    let tolerance = args[4].parse()?;
    let options = net::Options { tolerance, outliers: 0.003, max_control: 100_000 };
    let start = Instant::now();
    let (fitted, report) = net::fit(&quads, &body, body.points.len(), &options)?;
    println!("{report:?} {:.2?} diagonal {}", start.elapsed(), body.diagonal());
    let start = Instant::now();
    let (network, report) = patches::extract(&fitted.mesh, &fitted.surface)?;
    println!("{report:?} {:.2?}", start.elapsed());
    let mut a = network.seam_angles(4);
    a.sort_by(f64::total_cmp);
    println!(
        "seams mean {:.4} p95 {:.4} max {:.4} deg",
        a.iter().sum::<f64>().to_degrees() / a.len() as f64,
        a[a.len() * 95 / 100].to_degrees(),
        a[a.len() - 1].to_degrees()
    );
    let control = fitted.control();
    let mut sc = Vec::new();
    let mut worst = Vec::new();
    for q in 0..fitted.mesh.quads.len() {
        let at = |u: f64, v: f64, sc: &mut Vec<[f64; 3]>| {
            let j = fitted.surface.jet(
                &control,
                scan2step::spline::subdivision::QuadPlace {
                    quad: q,
                    at: scan2step::geometry::Uv::new(u, v),
                },
                sc,
            );
            (j[1].cross(&j[2]).normalize(), j[1].angle(&j[2]).to_degrees())
        };
        let (c, _) = at(0.5, 0.5, &mut sc);
        let mut m: f64 = 1.0;
        let (mut lo, mut hi) = (180.0f64, 0.0f64);
        for k in 0..49 {
            let (n, a) =
                at((k % 7) as f64 / 6.0 * 0.98 + 0.01, (k / 7) as f64 / 6.0 * 0.98 + 0.01, &mut sc);
            m = m.min(n.dot(&c));
            lo = lo.min(a);
            hi = hi.max(a);
        }
        worst.push((m, q, fitted.surface.is_regular(q), lo, hi));
    }
    worst.sort_by(|a, b| a.0.total_cmp(&b.0));
    println!(
        "limit turned: {} quads, worst {:.3?}",
        worst.iter().filter(|w| w.0 < 0.0).count(),
        &worst[..6]
    );
    let mut bad = 0;
    for (b, s) in network.surfaces.iter().enumerate() {
        let br = s.u.breaks();
        for w in br.windows(2) {
            for z in br.windows(2) {
                let (u, v) = (0.5 * (w[0] + w[1]), 0.5 * (z[0] + z[1]));
                let j = s.jet(scan2step::geometry::Uv::new(u, v));
                let n = j.su.cross(&j.sv).normalize();
                let (i, k) = (u.floor() as usize, v.floor() as usize);
                let q = b * 64 * (fitted.mesh.side / 8).pow(2) + fitted.mesh.side * k + i;
                let l = fitted.surface.jet(
                    &control,
                    scan2step::spline::subdivision::QuadPlace {
                        quad: q,
                        at: scan2step::geometry::Uv::new(u.fract(), v.fract()),
                    },
                    &mut sc,
                );
                if l[1].cross(&l[2]).normalize().dot(&n) < 0.5 {
                    bad += 1;
                    if bad < 6 {
                        println!(
                            "patch {b} at {u} {v} turned; angle limit {:.0} patch {:.0}",
                            l[1].angle(&l[2]).to_degrees(),
                            j.su.angle(&j.sv).to_degrees()
                        );
                    }
                }
            }
        }
    }
    println!("turned spans {bad}");
    let brep = brep::closed(&network, "body", 1e-7)?;
    println!("volume {} checked {:.2?}", brep.volume(brep.solids[0].outer), start.elapsed());
    step::write(&brep, &step::Options::default(), &mut fs::File::create(&args[3])?)?;
    Ok(())
}
