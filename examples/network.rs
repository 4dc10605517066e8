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
    let brep = brep::closed(&network, "body", 1e-7)?;
    println!("volume {} checked {:.2?}", brep.volume(brep.solids[0].outer), start.elapsed());
    step::write(&brep, &step::Options::default(), &mut fs::File::create(&args[3])?)?;
    Ok(())
}
