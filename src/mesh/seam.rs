//! Joins blocks of a scan along their common rims.
//!
//! Tiles, nodes of glTF and chunks of scanners repeat the points of their common rims with another rounding. Points
//! on rims that are far nearer to each other than the edges there are the same point. Only points of rims
//! are joined, and never two of one triangle.

use foldhash::HashSet;
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

use super::build::{Repairs, count};
use super::{EdgeMap, Mesh};
use crate::geometry::sets::Sets;
use crate::geometry::{Point, VertexId};

/// Points are the same if their distance is less than this share of the shortest edge at them. The points of scans vary
/// by tenths of an edge, and those of other roundings by millionths.
const SAME: f64 = 1e-3;

/// Or less than so many steps of the file's numbers. Both points may be rounded once in a transform and once in the
/// file, so that they are two steps apart along each of three axes.
const STEPS: f64 = 4.0;

/// But no more than this share of the shortest edge, so that no chain of joined points takes a triangle away.
const MOST: f64 = 0.25;

/// The distance up to which points of rims are joined.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) enum SeamWidth {
    /// A thousandth of the shortest edge there, or a few steps of the file's numbers.
    #[default]
    Auto,
    /// A length in mm, but no more than a quarter of the shortest edge there. 0 joins nothing.
    Fixed(f64),
}

/// Joins points on rims, and returns whether there were any to join. Of those that are joined, each has the number of
/// the first one afterwards. `number` has the point of each point of the file. The unit of the points is `mm`
/// millimetres long, and the largest numbers of their file are in steps of `step` of them.
pub(super) fn join_rims(
    mesh: &mut Mesh,
    edges: &EdgeMap,
    number: &mut [u32],
    (width, step, mm): (SeamWidth, f64, f64),
    repairs: &mut Repairs,
) -> bool {
    if width == SeamWidth::Fixed(0.0) {
        return false;
    }
    let Mesh { points, triangles } = mesh;
    let rims = rims(triangles, edges);
    let shortest = shortest_edges(points, triangles, &rims);
    let reach = |v: u32| {
        let edge = shortest[v as usize];
        let wanted = match width {
            SeamWidth::Auto => (SAME * edge).max(STEPS * step),
            SeamWidth::Fixed(length) => length / mm,
        };
        wanted.min(MOST * edge)
    };
    let place = |&v: &u32| GeomWithData::new(<[f64; 3]>::from(points[v as usize]), v);
    let tree = RTree::bulk_load(rims.iter().map(place).collect());
    let mut sets = Sets::new(points.len());
    for &v in &rims {
        let (p, far) = (points[v as usize], reach(v));
        let [low, high] = [-far, far].map(|d| p.coords.map(|x| x + d).into());
        for near in tree.locate_in_envelope(AABB::from_corners(low, high)) {
            let w = near.data;
            let distance = (points[w as usize] - p).norm();
            if w > v && distance <= far.min(reach(w)) {
                sets.join(v as usize, w as usize);
            }
        }
    }
    // The first point of each set stands for all.
    let first: Vec<u32> = (0..points.len()).map(|v| sets.find(v) as u32).collect();
    let joined = rims.iter().filter(|&&v| first[v as usize] != v).count();
    if joined == 0 {
        return false;
    }
    count(repairs, "joined_rim_vertices", joined);
    triangles.iter_mut().flatten().for_each(|v| *v = VertexId(first[v.index()]));
    number.iter_mut().for_each(|v| *v = first.get(*v as usize).copied().unwrap_or(*v));
    true
}

/// The vertices at the ends of sides that only one triangle has, in ascending order.
fn rims(triangles: &[[VertexId; 3]], edges: &EdgeMap) -> Vec<u32> {
    let shared: HashSet<u32> = edges.overfull().iter().flatten().copied().collect();
    let single = edges.open_sides().filter(|side| !shared.contains(&(*side as u32)));
    let ends = |side: usize| [0, 1].map(|k| triangles[side / 3][(side % 3 + k) % 3].0);
    let mut rims: Vec<u32> = single.flat_map(ends).collect();
    rims.sort_unstable();
    rims.dedup();
    rims
}

/// The length of the shortest edge at each vertex of a rim; 0 at other vertices.
fn shortest_edges(points: &[Point], triangles: &[[VertexId; 3]], rims: &[u32]) -> Vec<f64> {
    let mut shortest = vec![0.0; points.len()];
    rims.iter().for_each(|&v| shortest[v as usize] = f64::INFINITY);
    for t in triangles {
        for k in 0..3 {
            let [a, b] = [t[k].index(), t[(k + 1) % 3].index()];
            let length = (points[b] - points[a]).norm();
            for v in [a, b] {
                shortest[v] = length.min(shortest[v]);
            }
        }
    }
    shortest
}

#[cfg(test)]
mod tests {
    use formats::Soup;

    use super::*;
    use crate::geometry::random::scattered;
    use crate::mesh::{FileRounding, from_soup_joined};

    /// Two squares of two triangles beside each other. The common side of the second is moved by `off`.
    fn squares(off: f64) -> Mesh {
        let x = [0.0, 1.0, 1.0, 0.0, 1.0 + off, 2.0, 2.0, 1.0 + off];
        let y = [0.0, 0.0, 1.0, 1.0];
        let points = (0..8).map(|k| Point::new(x[k], y[k % 4], 0.1)).collect();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        Mesh { points, triangles: triangles.map(|t| t.map(VertexId)).to_vec() }
    }

    fn join(mesh: &mut Mesh, number: &mut [u32], width: (SeamWidth, f64, f64)) -> Repairs {
        let (edges, mut repairs) = (EdgeMap::new(mesh), Repairs::new());
        join_rims(mesh, &edges, number, width, &mut repairs);
        repairs
    }

    fn joined(off: f64, width: SeamWidth, step: f64) -> Option<usize> {
        let mut mesh = squares(off);
        let mut number: Vec<u32> = (0..8).collect();
        let repairs = join(&mut mesh, &mut number, (width, step, 10.0));
        if repairs.contains_key("joined_rim_vertices") {
            assert_eq!(number, [0, 1, 2, 3, 1, 5, 6, 2]);
            assert_eq!(mesh.triangles[2..], [[1, 5, 6], [1, 6, 2]].map(|t| t.map(VertexId)));
        }
        repairs.get("joined_rim_vertices").copied()
    }

    #[test]
    fn rims_far_nearer_than_their_edges_are_joined() {
        assert_eq!(joined(1e-6, SeamWidth::Auto, 0.0), Some(2));
        assert_eq!(joined(-5e-4, SeamWidth::Auto, 0.0), Some(2));
        assert_eq!(joined(1e-2, SeamWidth::Auto, 0.0), None);
        assert_eq!(joined(1e-6, SeamWidth::Fixed(0.0), 0.0), None);
        assert_eq!(joined(1e-2, SeamWidth::Fixed(0.5), 0.0), Some(2));
        assert_eq!(joined(1e-2, SeamWidth::Fixed(0.05), 0.0), None);
        assert_eq!(joined(0.3, SeamWidth::Fixed(1e9), 0.0), None);
        // A few steps of the file's numbers, but no more than a quarter of an edge.
        assert_eq!(joined(1e-2, SeamWidth::Auto, 1e-2), Some(2));
        assert_eq!(joined(5e-2, SeamWidth::Auto, 1e-2), None);
        assert_eq!(joined(0.3, SeamWidth::Auto, 0.2), None);
    }

    #[test]
    fn points_inside_of_a_sheet_stay() {
        // A fan whose inner point is very near to its neighbours, and both of whose rims are not.
        let points: Vec<Point> = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [1e-9, 0.0]]
            .map(|[x, y]| Point::new(x, y, 0.0))
            .to_vec();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 3, 1]].map(|t| t.map(VertexId)).to_vec();
        let mut mesh = Mesh { points, triangles };
        let mut number: Vec<u32> = (0..5).collect();
        let before = mesh.triangles[..2].to_vec();
        join(&mut mesh, &mut number, (SeamWidth::Auto, 1e-9, 1.0));
        assert_eq!(mesh.triangles[..2], before);
        assert_eq!(number, [0, 1, 2, 3, 0]);
    }

    /// Two blocks of a rough sheet. Their common rim is rounded twice, once for each.
    fn blocks(decimals: usize) -> Soup {
        let mut drawn = 0;
        let mut uneven = |most: f64| {
            drawn += 1;
            most * (scattered(drawn) as f64 / u64::MAX as f64 * 2.0 - 1.0)
        };
        let sheet: Vec<[f64; 3]> = (0..15 * 29)
            .map(|k| {
                [0, 1, 2].map(|axis| uneven(0.2) + [(k % 29) as f64, (k / 29) as f64, 3.0][axis])
            })
            .collect();
        let mut soup = Soup::default();
        for block in 0..2 {
            let first = soup.points.len() as u32;
            for k in 0..15 * 15 {
                let p = sheet[(k / 15) * 29 + k % 15 + 14 * block];
                let text = p.map(|x| format!("{:.decimals$}", x + uneven(4e-3)));
                soup.points.push(text.map(|text| text.parse().expect("a number")));
            }
            let corners = (0..14 * 14).map(|k| first + k / 14 * 15 + k % 14);
            corners.for_each(|v| soup.polygons.push([v, v + 1, v + 16, v + 15]));
        }
        soup
    }

    #[test]
    fn rims_of_blocks_in_rounded_numbers_are_joined() {
        let open = |soup: &Soup, step: f64| {
            let build = from_soup_joined(soup, 1.0, SeamWidth::Auto, step).expect("a mesh");
            EdgeMap::new(&build.mesh).open_sides().count()
        };
        let soup = blocks(2);
        assert_eq!(open(&soup, FileRounding::largest_step(&soup)), 2 * (28 + 14));
        assert!(open(&soup, 0.0) > 2 * (28 + 14));
        // With more digits, the same distances are those of a gap.
        let soup = blocks(5);
        assert_eq!(open(&soup, FileRounding::largest_step(&soup)), 4 * (14 + 14));
    }
}
