//! The connected components of a mesh, and the extraction of one of them as a disk.

use std::borrow::Cow;

use foldhash::{HashMap, HashMapExt, HashSet, HashSetExt};
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

use super::boundary::{self, Loop};
use super::build::{Build, Repairs, count};
use super::disk::Outer;
use super::handles::{self, Handle};
use super::islands::{self, IslandCandidate};
use super::raw_points::{FacePoints, RawPoints};
use super::stand_ins::StandIns;
use super::topology::Topology;
use super::vertices::VertexMap;
use super::{Disk, EdgeMap, Mesh, rims};
use crate::error::{Error, Result};
use crate::geometry::{Point, Vector, VertexId};

/// The rule that selects the component to convert.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Choice {
    /// Of a clean mesh every closed component, and of any other one the largest.
    #[default]
    Auto,
    /// The component with the most triangles.
    Largest,
    /// The n-th largest component, counted from 0.
    Number(usize),
}

impl Choice {
    /// The number of the component, where the largest one is 0.
    pub(crate) fn number(self) -> usize {
        match self {
            Choice::Auto | Choice::Largest => 0,
            Choice::Number(n) => n,
        }
    }
}

/// The mesh of a scan, divided into its connected components.
#[derive(Debug)]
pub struct Components {
    pub(super) build: Build,
    /// The triangles of each component in ascending order. The largest component comes first.
    pub(super) pieces: Vec<Vec<usize>>,
    /// The components that have only one side.
    twisted: HashSet<usize>,
    /// The first corner of each component that is not dust, with the number of the component.
    begins: RTree<GeomWithData<[f64; 3], usize>>,
    dust: usize,
    /// What was measured, if the mesh was made of a cloud.
    raw: Option<RawPoints>,
    /// Where the places are measured from in the scan's own frame, in mm, if the mesh was made of no cloud.
    origin: [f64; 3],
    /// The longest loop of a handle that is cut, in mm, if one is named.
    handles: Option<f64>,
}

/// A component is dust if it has fewer triangles than the first value and less than the second
/// value's share of the triangles of the largest component.
const DUST: (usize, f64) = (64, 0.01);

/// A sample pays if it has fewer than one in so many triangles.
const MANY: usize = 200;

/// One component, extracted from the mesh.
#[derive(Debug)]
pub struct Component {
    pub(super) build: Build,
    /// The topology of the component.
    pub topology: Topology,
    /// The number of triangles in all other components.
    pub left_out: usize,
    /// The handles that were cut, in the unit of the mesh.
    pub handles: Vec<Handle>,
    /// Components that may be islands in its holes, the largest first.
    others: Vec<IslandCandidate>,
}

impl Components {
    /// Finds the components.
    pub fn new(mut build: Build) -> Self {
        let pieces = pieces(&build);
        let largest = pieces.first().map_or(0, Vec::len);
        let is_dust = |n: usize| n < DUST.0 && (n as f64) < DUST.1 * largest as f64;
        let dust = pieces.iter().filter(|piece| is_dust(piece.len())).count();
        count(&mut build.repairs, "dust_components", dust);
        let twisted = twisted(&build, &pieces);
        let begin = |(n, piece): (usize, &Vec<usize>)| {
            let first = build.mesh.triangles[piece[0]][0];
            GeomWithData::new(build.mesh.point(first).into(), n)
        };
        let sizeable = &pieces[..pieces.len() - dust];
        let begins = RTree::bulk_load(sizeable.iter().enumerate().map(begin).collect());
        Components {
            build,
            pieces,
            twisted,
            begins,
            dust,
            raw: None,
            origin: [0.0; 3],
            handles: None,
        }
    }

    /// The same with the points that the mesh was made of. `unit` is the length in mm of the unit
    /// of these points and of the soup.
    #[must_use]
    pub fn with_raw_points(self, raw: RawPoints, unit: f64) -> Self {
        let raw = Some(raw.scaled(unit / self.mm()));
        Components { raw, ..self }
    }

    /// The same, measured from this point of the scan's own frame, in mm.
    #[must_use]
    pub(crate) fn measured_from(self, origin: [f64; 3]) -> Self {
        Components { origin, ..self }
    }

    /// Where places are measured from in the scan's own frame, in mm.
    pub fn origin(&self) -> [f64; 3] {
        let mm = self.mm();
        self.raw.as_ref().map_or(self.origin, |raw| raw.origin().map(|x| mm * x))
    }

    /// The same with a named length in mm: handles whose loops are not longer are cut in the
    /// components that are extracted. Without one, handles of a few edges are cut, and in the mesh of a
    /// cloud also those of up to 4π edges. At 0 none are.
    #[must_use]
    pub fn with_handles(self, longest: Option<f64>) -> Self {
        Components { handles: longest, ..self }
    }

    /// The points that the mesh was made of, in its unit of length, if it was made of a cloud.
    pub fn raw_points(&self) -> Option<&RawPoints> {
        self.raw.as_ref()
    }

    /// The number of components.
    pub fn count(&self) -> usize {
        self.pieces.len()
    }

    /// The number of components that are not dust. Dust comes last in the order of components.
    pub fn sizeable(&self) -> usize {
        self.pieces.len() - self.dust
    }

    /// The number of triangles of each component.
    pub fn sizes(&self) -> Vec<usize> {
        self.pieces.iter().map(Vec::len).collect()
    }

    /// The components that are worth a face: all but dust and islands of others.
    pub fn all(&self, outer: Outer) -> Vec<Choice> {
        self.without_islands(outer).into_iter().map(Choice::Number).collect()
    }

    /// The components besides dust that are no island of another one.
    pub fn without_islands(&self, outer: Outer) -> Vec<usize> {
        let mut found = HashSet::new();
        for n in 0..self.sizeable() {
            // The islands of an island are already found with the piece around it.
            if !found.contains(&n) {
                found.extend(self.islands_of(n, outer));
            }
        }
        (0..self.sizeable()).filter(|n| !found.contains(n)).collect()
    }

    /// The components that are islands of the given one.
    fn islands_of(&self, component: usize, outer: Outer) -> Vec<usize> {
        let taken = self.take(Choice::Number(component)).ok().filter(|c| !c.others.is_empty());
        let disk = taken.and_then(|c| c.into_disk(outer, &mut Repairs::new()).ok());
        disk.map_or(Vec::new(), |d| d.islands.iter().map(|island| island.component).collect())
    }

    /// The repairs made in the whole scan.
    pub fn repairs(&self) -> &Repairs {
        &self.build.repairs
    }

    /// The length in mm of one unit of the mesh.
    pub fn mm(&self) -> f64 {
        self.build.mm
    }

    /// The length of the scan's unit in that of the mesh.
    pub(crate) fn unit(&self) -> f64 {
        self.build.unit
    }

    /// Whether a component has two sides and no boundary. One that does not exist has neither.
    pub(crate) fn is_closed(&self, component: Choice) -> bool {
        let across =
            |&t: &usize| (3 * t..3 * t + 3).all(|side| self.build.edges.across(side).is_some());
        let number = component.number();
        self.pieces.get(number).is_some_and(|piece| piece.iter().all(across))
            && !self.twisted.contains(&number)
    }

    /// Which of these points each vertex of the scan became. They are points of the mesh, each at a place of its own.
    pub(crate) fn vertices_of(&self, points: &[Point]) -> VertexMap {
        VertexMap::new(&self.build, points)
    }

    /// What was measured of a face that has these vertices: points of the cloud that the mesh was
    /// made of, or else the vertices themselves. They are points of the mesh, in its own lengths,
    /// each at a place of its own.
    pub(crate) fn measured_points<'a>(&self, vertices: &'a [Point]) -> FacePoints<'a> {
        let map = VertexMap::new(&self.build, vertices);
        match &self.raw {
            Some(raw) => raw.of_face(&map),
            None => FacePoints { points: vertices.into(), vertex_of: None, map },
        }
    }

    /// For each of these vertices of a face, or for each that stands for some of them, the number of points of the
    /// cloud that it stands for. `None` if the mesh was not made of a cloud.
    pub(crate) fn point_counts(
        &self,
        vertices: &[Point],
        stand_ins: Option<&StandIns>,
    ) -> Option<Vec<f64>> {
        let raw = self.raw.as_ref()?;
        let counts = raw.counts(&VertexMap::new(&self.build, vertices), vertices.len());
        Some(match stand_ins {
            Some(stand_ins) => stand_ins.sums(&counts),
            None => counts,
        })
    }

    /// A disk of the scan with its vertices where they were measured. In a mesh of a cloud they are
    /// on the surface that their neighbours sample, and what noise they have left is no longer
    /// independent. Smoothing could not tell it from shape.
    pub(crate) fn at_measured_places<'a>(&self, disk: &'a Disk) -> Cow<'a, Disk> {
        let raw = self.raw.as_ref().filter(|raw| raw.has_measured_vertices());
        let Some(raw) = raw else { return Cow::Borrowed(disk) };
        let mut disk = disk.clone();
        let map = VertexMap::new(&self.build, &disk.mesh.points);
        raw.place_measured(&map, &mut disk.mesh.points);
        Cow::Owned(disk)
    }

    /// Some triangles of a component, spread evenly, each with its neighbours. `None` if the component has not many more
    /// than `count` triangles.
    pub(crate) fn sampled(&self, component: Choice, count: usize) -> Option<Mesh> {
        let piece = self.pieces.get(component.number())?;
        let step = piece.len() / count;
        let around = |&t: &usize| {
            let across = (3 * t..3 * t + 3).filter_map(|side| self.build.edges.across(side));
            std::iter::once(t).chain(across.map(|side| side / 3))
        };
        let mut chosen: Vec<usize> = piece.iter().step_by(step.max(1)).flat_map(around).collect();
        chosen.sort_unstable();
        chosen.dedup();
        (step >= MANY).then(|| small_part(&self.build, &chosen).mesh)
    }

    /// Extracts one component.
    ///
    /// # Errors
    /// [`Error::Component`] if there is no component with this number.
    pub fn take(&self, choice: Choice) -> Result<Component> {
        self.extract(choice, true)
    }

    /// Extracts one component with all its handles: in a clean mesh they are bores.
    pub(crate) fn take_whole(&self, choice: Choice) -> Result<Component> {
        self.extract(choice, false)
    }

    fn extract(&self, choice: Choice, cuts_handles: bool) -> Result<Component> {
        let asked = choice.number();
        let piece =
            self.pieces.get(asked).ok_or(Error::Component { asked, count: self.count() })?;
        // A component with less than half of all triangles is extracted in a time that does not
        // depend on the size of the mesh. At most two components are larger.
        let is_small = 2 * piece.len() < self.build.mesh.triangles.len();
        let mut build =
            if is_small { small_part(&self.build, piece) } else { self.build.part(piece) };
        let orientable = !self.twisted.contains(&asked);
        let mut topology = Topology::new(&build.mesh, &build.edges, orientable);
        let mut cut_handles = Vec::new();
        if cuts_handles && orientable && topology.genus() > 0.0 {
            let named = self.handles.map(|longest| longest / self.mm());
            let of_cloud = self.raw.is_some();
            let lengths =
                named.map_or_else(|| handles::lengths(&build.mesh, of_cloud), |l| vec![l]);
            for longest in lengths {
                cut_handles.extend(handles::cut(&mut build, longest));
            }
            topology = Topology::new(&build.mesh, &build.edges, orientable);
        }
        let left_out = self.build.mesh.triangles.len() - piece.len();
        let others = match topology.check_disk() {
            Ok(()) if topology.loops > 1 => self.candidates(asked, &build.mesh),
            _ => Vec::new(),
        };
        Ok(Component { build, topology, left_out, handles: cut_handles, others })
    }

    /// The two-sided components near a mesh that are not dust.
    fn candidates(&self, chosen: usize, mesh: &Mesh) -> Vec<IslandCandidate> {
        let [low, high] = mesh.bounds();
        let margin = Vector::repeat(0.5 * mesh.diagonal());
        let around = AABB::from_corners((low - margin).into(), (high + margin).into());
        let near = self.begins.locate_in_envelope(around).map(|begin| begin.data);
        let mut near: Vec<usize> =
            near.filter(|n| *n != chosen && !self.twisted.contains(n)).collect();
        near.sort_unstable();
        let part =
            |n| IslandCandidate { component: n, build: small_part(&self.build, &self.pieces[n]) };
        near.into_iter().map(part).collect()
    }
}

impl Component {
    /// Its triangles and points, in mm.
    pub fn mesh(&self) -> Mesh {
        self.own_mesh().clone().scaled(self.mm())
    }

    /// Its triangles and points in the pipeline's unit of length.
    pub(crate) fn own_mesh(&self) -> &Mesh {
        &self.build.mesh
    }

    /// The length in mm of the pipeline's unit.
    pub fn mm(&self) -> f64 {
        self.build.mm
    }

    /// The boundary loops of a two-sided component.
    pub fn loops(&self) -> Vec<Loop> {
        boundary::boundary_loops(&self.build.mesh, &self.build.edges)
    }

    /// The position of the outer loop among `loops`.
    pub fn outer(&self, outer: Outer, loops: &[Loop]) -> usize {
        outer.in_lengths(self.mm()).among(&self.build.mesh, &self.build.edges, loops)
    }

    /// Makes a disk with holes of the component, in mm, and cleans its rims. Where several fans
    /// meet at one place (a bow-tie), only the largest is kept. Triangles that share a single side
    /// with the rest are removed. Other components that lie in its holes are added as islands. The
    /// removals are added to `repairs`.
    ///
    /// # Errors
    /// Those of [`Topology::check_disk`], and [`Error::Empty`] if nothing is left.
    pub fn into_disk(self, outer: Outer, repairs: &mut Repairs) -> Result<Disk> {
        let mm = self.mm();
        Ok(self.into_own_disk(outer.in_lengths(mm), repairs)?.scaled(mm))
    }

    /// Like [`Component::into_disk`], but in the unit of the mesh ([`Components::mm`]). The point
    /// of `outer` is in this unit, too.
    pub fn into_own_disk(self, outer: Outer, repairs: &mut Repairs) -> Result<Disk> {
        self.topology.check_disk()?;
        let mut taken = HashSet::new();
        let mut disk = clean(self.build, outer, &mut taken, repairs)?;
        islands::add(&mut disk, self.others, &mut taken, repairs);
        Ok(disk)
    }
}

/// Makes a disk of a component and cleans its rims. Triangles at a place in `taken` touch another
/// piece and are removed. The places on the boundary of the disk are added to `taken`.
pub(super) fn clean(
    mut build: Build,
    outer: Outer,
    taken: &mut HashSet<u32>,
    repairs: &mut Repairs,
) -> Result<Disk> {
    let before = build.mesh.triangles.len();
    while trim_bow_ties(&mut build, taken) {}
    count(repairs, "faces_dropped_at_bow_ties", before - build.mesh.triangles.len());
    if build.place.iter().any(|place| taken.contains(place)) {
        return Err(Error::Empty("every triangle touches another piece".into()));
    }
    let boundary = build.edges.open_sides().map(|side| build.mesh.triangles[side / 3][side % 3]);
    taken.extend(boundary.map(|v| build.place[v.index()]));
    let disk = Disk::new(build.mesh, &build.edges, outer)?;
    let (disk, hanging) = rims::trim_hanging(disk, build.edges, outer)?;
    count(repairs, "rim_triangles_trimmed", hanging);
    Ok(disk)
}

/// Extracts a component as [`Build::part`] does, in a time that does not depend on the size of the
/// whole mesh.
fn small_part(build: &Build, triangles: &[usize]) -> Build {
    let corners = triangles.iter().map(|&t| build.mesh.triangles[t]);
    let mut old: Vec<VertexId> = corners.clone().flatten().collect();
    old.sort_unstable();
    old.dedup();
    let number = |v: VertexId| VertexId::from(old.partition_point(|&w| w < v));
    let mesh = Mesh {
        points: old.iter().map(|&v| build.mesh.point(v)).collect(),
        triangles: corners.map(|t| t.map(number)).collect(),
    };
    let place = old.iter().map(|v| build.place[v.index()]).collect();
    Build { unit: build.unit, ..Build::new(mesh, place, build.mm) }
}

/// The components that have only one side.
fn twisted(build: &Build, pieces: &[Vec<usize>]) -> HashSet<usize> {
    if build.twisted.is_empty() {
        return HashSet::new();
    }
    let of: HashSet<usize> = build.twisted.iter().copied().collect();
    let is_twisted = |n: &usize| pieces[*n].iter().any(|t| of.contains(t));
    (0..pieces.len()).filter(is_twisted).collect()
}

/// The triangles of each component in ascending order. The largest component comes first.
pub(super) fn pieces(build: &Build) -> Vec<Vec<usize>> {
    let n = build.mesh.triangles.len();
    let mut seen = vec![false; n];
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for first in 0..n {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut piece = vec![first];
        let mut done = 0;
        while let Some(&t) = piece.get(done) {
            done += 1;
            for other in (3 * t..3 * t + 3).filter_map(|side| build.edges.across(side)) {
                if !std::mem::replace(&mut seen[other / 3], true) {
                    piece.push(other / 3);
                }
            }
        }
        piece.sort_unstable();
        pieces.push(piece);
    }
    pieces.sort_by_key(|p| (std::cmp::Reverse(p.len()), p[0]));
    pieces
}

/// Removes the smaller fans at every place with several fans, and all fans at places that another
/// piece has taken. Returns whether anything was removed; the caller repeats it until nothing is.
pub(super) fn trim_bow_ties(build: &mut Build, taken: &HashSet<u32>) -> bool {
    if taken.is_empty() && build.place.is_sorted_by(|a, b| a < b) {
        // Every place has a single fan.
        return false;
    }
    let mut fan_size = vec![0u32; build.mesh.points.len()];
    for v in build.mesh.triangles.iter().flatten() {
        fan_size[v.index()] += 1;
    }
    // The largest fan at each place; the first one among fans of equal size.
    let mut best = HashMap::with_capacity(build.place.len());
    for (v, &place) in build.place.iter().enumerate() {
        let incumbent = best.entry(place).or_insert(v);
        if fan_size[v] > fan_size[*incumbent] {
            *incumbent = v;
        }
    }
    let loses = |(v, place): (usize, &u32)| best[place] != v || taken.contains(place);
    let loses: Vec<bool> = build.place.iter().enumerate().map(loses).collect();
    let dropped: HashSet<usize> = build
        .mesh
        .triangles
        .iter()
        .enumerate()
        .filter(|(_, t)| t.iter().any(|v| loses[v.index()]))
        .map(|(i, _)| i)
        .collect();
    if dropped.is_empty() || dropped.len() == build.mesh.triangles.len() {
        return false;
    }
    build.drop_triangles(&dropped);
    build.edges = EdgeMap::new(&build.mesh);
    while build.open_fans() {
        build.edges = EdgeMap::new(&build.mesh);
    }
    let largest = pieces(build).swap_remove(0);
    *build = build.part(&largest);
    true
}
