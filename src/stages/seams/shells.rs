//! The shells of a mesh: connected closed parts, each a solid or a void in one.

use formats::Brep;
use formats::brep::{ShellId, Solid};

use super::{FacePatch, SolidFault};
use crate::geometry::VertexId;
use crate::geometry::sets::Sets;
use crate::mesh::{EdgeMap, Mesh};

/// One closed part of a mesh, with patches of its own.
pub(super) struct ShellPart {
    pub mesh: Mesh,
    pub errors: Vec<f64>,
    pub patches: Vec<FacePatch>,
    /// For each triangle its number in the whole mesh.
    triangles: Vec<u32>,
    /// The part around it if this one is a void.
    pub void_in: Option<usize>,
}

/// Checks that a mesh faces one way, and is closed unless it may be open.
pub(super) fn check(mesh: &Mesh, edges: &EdgeMap, may_be_open: bool) -> Result<(), SolidFault> {
    let is_open = |&side: &usize| edges.across(side).is_none();
    let open: Vec<usize> = (0..3 * mesh.triangles.len()).filter(is_open).collect();
    if let Some(&first) = open.first().filter(|_| !may_be_open) {
        let place = mesh.point(mesh.side(first).0);
        return Err(SolidFault::Open { edges: open.len(), place });
    }
    let is_inverted = |&side: &usize| {
        let (a, b) = mesh.side(side);
        edges.across(side).is_some_and(|twin| mesh.side(twin) != (b, a))
    };
    match (0..3 * mesh.triangles.len()).find(is_inverted) {
        Some(side) => Err(SolidFault::Unoriented { place: mesh.point(mesh.side(side).0) }),
        None if mesh.triangles.is_empty() => Err(SolidFault::Empty),
        None => Ok(()),
    }
}

/// The parts of a checked mesh. A vertex where several fans of triangles meet becomes one for each. Parts that face
/// inwards are turned, unless they are voids. Triangles without a patch become facets.
pub(super) fn split(
    mesh: &Mesh,
    errors: &[f64],
    edges: &EdgeMap,
    patches: &[FacePatch],
) -> Vec<ShellPart> {
    let count = mesh.triangles.len();
    let mut of_shells = Sets::new(count);
    let mut of_corners = Sets::new(3 * count);
    let next = |side: usize| 3 * (side / 3) + (side + 1) % 3;
    for side in 0..3 * count {
        if let Some(twin) = edges.across(side) {
            of_shells.join(side / 3, twin / 3);
            of_corners.join(side, next(twin));
        }
    }
    let mut fan = vec![0; 3 * count];
    for (number, corners) in of_corners.members().iter().enumerate() {
        corners.iter().for_each(|&corner| fan[corner as usize] = number);
    }
    let mut patch_of: Vec<Option<usize>> = vec![None; count];
    for (number, patch) in patches.iter().enumerate() {
        patch.triangles.iter().for_each(|&t| patch_of[t as usize] = Some(number));
    }
    let make = |triangles: Vec<u32>| part(mesh, errors, patches, &patch_of, &fan, &triangles);
    let mut parts: Vec<ShellPart> = of_shells.members().into_iter().map(make).collect();
    if edges.open_sides().next().is_none() {
        nest(&mut parts);
    }
    parts
}

fn part(
    mesh: &Mesh,
    errors: &[f64],
    patches: &[FacePatch],
    patch_of: &[Option<usize>],
    fan: &[usize],
    triangles: &[u32],
) -> ShellPart {
    let mut fans: Vec<usize> =
        triangles.iter().flat_map(|&t| (0..3).map(move |k| fan[3 * t as usize + k])).collect();
    fans.sort_unstable();
    fans.dedup();
    let mut made = Mesh { points: vec![Default::default(); fans.len()], triangles: Vec::new() };
    let mut own_errors = vec![0.0; fans.len()];
    let mut own: Vec<(Option<usize>, u32)> = Vec::new();
    for (k, &t) in triangles.iter().enumerate() {
        let corners = [0, 1, 2].map(|k| {
            let v = mesh.triangles[t as usize][k];
            let new = fans.partition_point(|&f| f < fan[3 * t as usize + k]);
            made.points[new] = mesh.point(v);
            own_errors[new] = errors[v.index()];
            VertexId::from(new)
        });
        made.triangles.push(corners);
        own.push((patch_of[t as usize], k as u32));
    }
    own.sort_unstable();
    let groups = own.chunk_by(|a, b| a.0 == b.0 && a.0.is_some());
    let own_patches = groups.map(|group| {
        let triangles = group.iter().map(|&(_, t)| t).collect();
        match group[0].0 {
            Some(number) => FacePatch { triangles, ..patches[number].clone() },
            None => FacePatch::facet(&made, triangles),
        }
    });
    let patches = own_patches.collect();
    let triangles = triangles.to_vec();
    ShellPart { mesh: made, errors: own_errors, patches, triangles, void_in: None }
}

/// Finds the voids, and turns the other parts so that they face outwards. A part is a void in the nearest part around
/// it if the two face opposite ways.
fn nest(parts: &mut [ShellPart]) {
    let inwards: Vec<bool> = parts.iter().map(|part| part.mesh.signed_volume() < 0.0).collect();
    let boxes: Vec<_> = parts.iter().map(|part| part.mesh.bounds()).collect();
    let is_around = |outer: usize, inner: usize| {
        let ([low, high], [from, to]) = (boxes[outer], boxes[inner]);
        outer != inner
            && (0..3).all(|k| low[k] < from[k] && to[k] < high[k])
            && parts[outer].mesh.goes_around(parts[inner].mesh.points[0])
    };
    let around: Vec<Vec<usize>> = (0..parts.len())
        .map(|inner| (0..parts.len()).filter(|&outer| is_around(outer, inner)).collect())
        .collect();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&k| around[k].len());
    for k in order {
        let nearest = around[k].iter().copied().max_by_key(|&outer| around[outer].len());
        // A void in a void is a solid again, as the parts around it come first.
        parts[k].void_in =
            nearest.filter(|&outer| inwards[outer] != inwards[k] && parts[outer].void_in.is_none());
        if inwards[k] != parts[k].void_in.is_some() {
            parts[k].turn();
        }
    }
}

impl ShellPart {
    /// A patch of this part with the numbers that its triangles have in the whole mesh.
    pub(super) fn in_whole(&self, patch: FacePatch) -> FacePatch {
        let triangles = patch.triangles.iter().map(|&t| self.triangles[t as usize]).collect();
        FacePatch { triangles, ..patch }
    }

    fn turn(&mut self) {
        self.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.patches.iter_mut().for_each(|patch| patch.side = -patch.side);
    }
}

/// Puts the shells of all parts into one model.
pub(super) fn join(parts: &[ShellPart], shells: Vec<Brep>, name: &str) -> Brep {
    let mut whole = Brep { name: name.into(), ..Brep::default() };
    shells.into_iter().for_each(|shell| whole.append(shell));
    let void = |outer: usize| {
        let own = move |k: &usize| parts[*k].void_in == Some(outer);
        (0..parts.len()).filter(own).map(ShellId).collect()
    };
    let is_solid = |k: &usize| parts[*k].void_in.is_none() && whole.shells[*k].closed;
    let outer: Vec<usize> = (0..parts.len()).filter(is_solid).collect();
    whole.solids = outer.into_iter().map(|k| Solid { outer: ShellId(k), voids: void(k) }).collect();
    whole
}
