//! How much memory a conversion may take, estimated from counts before the work begins.

use formats::scene::{FormId, NodeId};
use formats::{Scene, Soup};

use super::Options;
use crate::error::{Error, Result};
use crate::stages::cloud;
use crate::stages::smooth::Support;

/// The counts that decide how much memory a conversion takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// Vertices of the scan.
    pub vertices: usize,
    /// Triangles of the scan. A polygon of n corners counts as n − 2.
    pub triangles: usize,
    /// Points of a cloud that the mesh is made of; 0 for a mesh.
    pub points: usize,
    /// The largest number of control points that the fit may use.
    pub control_points: usize,
    /// What the vertices are means of ([`Options::fitting`]).
    pub averaged: MeansOf,
    /// Whether a report draws the scan, too: a page or a picture.
    pub is_drawn: bool,
    /// Whether the scan may become a solid or a shell.
    pub may_be_body: bool,
}

/// What vertices are means of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeansOf {
    /// Of nothing: they are those of the scan.
    Nothing,
    /// Of the points of a cloud.
    Points,
    /// Of the vertices of a mesh with so many vertices and triangles.
    Mesh([usize; 2]),
}

/// Bytes of the program itself.
const PROGRAM: u64 = 25_000_000;

/// Bytes for each triangle and each vertex of the file, through all stages but the fit. The
/// largest value measured, on scans of 4,000 to a million vertices, is 800 for each triangle,
/// where many holes are filled; scans without holes take 300. The counts do not show how much
/// the fills add, so the estimate takes the worst case and a quarter more.
const TRIANGLE: u64 = 1_000;
/// The same for each point of a cloud that stays while its mesh is converted: its place, its vertex and
/// its distance from the face. Making the mesh takes less than the stages after it. A vertex whose mean is smoothed takes
/// as much: 190 were measured.
const VERTEX: u64 = 200;
/// The same for each point of a cloud of which means are meshed. Measured: 125 for 20 million points.
const AVERAGED_POINT: u64 = 160;
/// The same for each vertex of a mesh and each of its triangles, while means are taken of its vertices. Measured: 288 and
/// 277 for a vertex with its two triangles, of 4 and 20 million.
const AVERAGING: [u64; 2] = [100, 95];

/// Fewer places than these are not chosen to save memory.
const LEAST_PLACES: usize = 10_000;

/// Bytes for each triangle if a report draws the scan, and for its picture whatever the scan is.
/// Measured for the picture: 153 MB.
const DRAWN_TRIANGLE: u64 = 300;
const PICTURE: u64 = 170_000_000;

/// Bytes that the layout, the net and the faces of a body take besides. Small bodies of many faces took up
/// to 55 MB more than a face of as many points may take; large ones took less.
const BODY: u64 = 70_000_000;

/// Bytes for each control point while the largest net is fitted. Measured: 4,250 for a uniform
/// net, 5,500 where a tolerance that cannot be met takes the largest net allowed, 14,000 where
/// folds are removed all over the net.
const CONTROL_POINT: u64 = 16_000;

impl Memory {
    /// The counts of a conversion of a scan without drawings.
    pub fn of(soup: &Soup, options: &Options) -> Self {
        Memory::of_counts([soup.points.len(), soup.polygons.triangle_count()], options)
    }

    /// The same for a scan with so many vertices and triangles.
    pub fn of_counts([vertices, triangles]: [usize; 2], options: &Options) -> Self {
        let control_points = largest_net(options, vertices);
        Memory {
            vertices,
            triangles,
            points: 0,
            averaged: MeansOf::Nothing,
            control_points,
            is_drawn: false,
            may_be_body: false,
        }
    }

    /// The same for the parts of a scene. Their meshes are all in memory, and as many nets as there are threads.
    pub fn of_scene(scene: &Scene, options: &Options) -> Self {
        let count = |(form, _): &(FormId, Vec<NodeId>)| {
            let soup = &scene.meshes()[scene.forms()[form.0].mesh.0].soup;
            [soup.points.len(), soup.polygons.triangle_count()]
        };
        let counts: Vec<[usize; 2]> = scene.uses().iter().map(count).collect();
        let sum = |k: usize| counts.iter().map(|count| count[k]).sum::<usize>();
        let mut nets: Vec<usize> =
            counts.iter().map(|[vertices, _]| largest_net(options, *vertices)).collect();
        nets.sort_unstable_by(|a, b| b.cmp(a));
        let control_points =
            nets.into_iter().take(options.threads.unwrap_or_else(rayon::current_num_threads));
        let control_points = control_points.fold(0, usize::saturating_add);
        Memory { control_points, may_be_body: true, ..Memory::of_counts([sum(0), sum(1)], options) }
    }

    /// The same for a cloud of so many points. Each may become a vertex, and a surface has about
    /// twice as many triangles as vertices.
    pub fn of_cloud(points: usize, options: &Options) -> Self {
        Memory { points, ..Memory::of_counts([points, points.saturating_mul(2)], options) }
    }

    /// Bytes that the process may need. It takes less for most scans; no scan of the
    /// measurements took more.
    pub fn bytes(&self) -> u64 {
        let (picture, drawn) = if self.is_drawn { (PICTURE, DRAWN_TRIANGLE) } else { (0, 0) };
        let each = |count: usize, bytes: u64| (count as u64).saturating_mul(bytes);
        let (before, kept) = match self.averaged {
            MeansOf::Nothing => (0, each(self.points, VERTEX)),
            MeansOf::Points => (0, each(self.points, AVERAGED_POINT)),
            MeansOf::Mesh([vertices, triangles]) => {
                let before = each(vertices, AVERAGING[0])
                    .saturating_add(each(triangles, AVERAGING[1] + drawn));
                (before, each(vertices, VERTEX))
            }
        };
        let parts = [
            picture,
            if self.may_be_body { BODY } else { 0 },
            kept,
            each(self.triangles, TRIANGLE + drawn),
            each(self.vertices, VERTEX),
            each(self.control_points, CONTROL_POINT),
        ];
        let after = parts.into_iter().fold(0, u64::saturating_add);
        before.max(after).saturating_add(PROGRAM)
    }

    /// The same for a cloud or a mesh of which the means at so many places are taken.
    fn averaged(&self, places: usize, options: &Options) -> Self {
        let of_means = Memory::of_counts([places, places.saturating_mul(2)], options);
        let &Memory { vertices, triangles, points, is_drawn, may_be_body, .. } = self;
        let averaged = match points {
            0 => MeansOf::Mesh([vertices, triangles]),
            _ => MeansOf::Points,
        };
        Memory { points, averaged, is_drawn, may_be_body, ..of_means }
    }

    /// Refuses a conversion that may need more bytes than allowed.
    ///
    /// # Errors
    /// [`Error::MaxMemory`]: it may.
    pub fn check(&self, allowed: u64) -> Result<()> {
        self.check_with(allowed, None)
    }

    /// The same, where means may need so many bytes.
    fn check_with(&self, allowed: u64, averaged: Option<u64>) -> Result<()> {
        let Memory { vertices, triangles, control_points, .. } = *self;
        match self.bytes() {
            needed if needed <= allowed => Ok(()),
            needed => Err(Error::MaxMemory {
                needed,
                allowed,
                vertices,
                triangles,
                control_points,
                averaged,
            }),
        }
    }
}

impl Options {
    /// The same for a conversion that may need `memory`, and is allowed so many bytes. If the points of a cloud or the
    /// vertices of a mesh may need more, their means at fewer places are taken: at as many as fit. A mesh whose noise does
    /// not hide what means lose is refused by its conversion.
    ///
    /// # Errors
    /// [`Error::MaxMemory`]: it may need more even with means at 10,000 places, or is a mesh each of whose vertices counts,
    /// as the options name a tolerance or how it is smoothed.
    pub fn fitting(&self, memory: &Memory, allowed: u64) -> Result<Options> {
        let is_mesh = memory.points == 0;
        let count = if is_mesh { memory.vertices } else { memory.points };
        let may_average =
            !is_mesh || (self.tolerance.is_none() && self.smooth.support == Support::Auto);
        let bytes = |places: usize| memory.averaged(places, self).bytes();
        let least = (may_average && count > LEAST_PLACES).then(|| bytes(LEAST_PLACES));
        if memory.bytes() <= allowed || least.is_none_or(|least| least > allowed) {
            return memory.check_with(allowed, least).map(|()| self.clone());
        }
        let (mut few, mut many) = (LEAST_PLACES, count);
        while many - few > 1 {
            let middle = few.midpoint(many);
            *(if bytes(middle) <= allowed { &mut few } else { &mut many }) = middle;
        }
        if is_mesh {
            let bound = Some(MemoryBound { memory: *memory, allowed, places: few });
            return Ok(Options { bound, ..self.clone() });
        }
        let cloud = cloud::Options { most_places: Some(few), ..self.cloud.clone() };
        Ok(Options { cloud, ..self.clone() })
    }
}

/// A bound on memory that a mesh holds if it is averaged.
#[derive(Debug, Clone)]
pub(crate) struct MemoryBound {
    /// What the mesh may need otherwise.
    memory: Memory,
    allowed: u64,
    places: usize,
}

impl MemoryBound {
    /// The largest number of means.
    pub(super) fn places(&self) -> usize {
        self.places
    }

    /// The same for a component of so many vertices.
    pub(super) fn most_of(&self, vertices: usize) -> usize {
        (vertices as f64 / self.memory.vertices as f64 * self.places as f64) as usize
    }

    /// Refuses a mesh that cannot be averaged.
    ///
    /// # Errors
    /// [`Error::MaxMemory`].
    pub(super) fn refuse(&self) -> Result<()> {
        self.memory.check(self.allowed)
    }
}

/// The largest number of control points. Without a tolerance and without knots by the caller
/// the points of the scan bound it: the fit never takes more than half as many. A tolerance, a
/// κ or a depth that is named may take as many as `max_net` allows.
fn largest_net(options: &Options, vertices: usize) -> usize {
    let knots = &options.knots;
    let is_named = options.tolerance.is_some() || knots.kappa.is_some() || knots.depth.is_some();
    match knots.net {
        Some([m, n]) => m.saturating_mul(n),
        None if is_named => knots.largest_net(),
        None => knots.largest_net().min(vertices / 2),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::Builder;

    fn largest(change: impl FnOnce(Builder) -> Builder) -> usize {
        let options = change(Options::builder().max_net(5000)).build().unwrap();
        Memory::of_counts([1000, 2000], &options).control_points
    }

    #[test]
    fn knots_that_are_named_may_make_the_largest_net() {
        assert_eq!(largest(|options| options), 500);
        assert_eq!(largest(|options| options.net([20, 30])), 600);
        assert_eq!(largest(|options| options.tolerance(0.1)), 5000);
        assert_eq!(largest(|options| options.kappa(0.1)), 5000);
        assert_eq!(largest(|options| options.depth(6_u32)), 5000);
    }

    #[test]
    fn a_conversion_is_refused_that_may_need_a_byte_too_many() {
        let memory = Memory::of_counts([4000, 7657], &Options::default());
        let needed = 25_000_000 + 4000 * 200 + 7657 * 1000 + 2000 * 16_000;
        assert_eq!(memory.bytes(), needed);
        assert!(memory.check(needed).is_ok());
        let refused = memory.check(needed - 1).unwrap_err().to_string();
        assert!(refused.starts_with("may need 65.5 MB for 4000 vertices"), "{refused}");
        let drawn = Memory { is_drawn: true, ..memory };
        assert_eq!(drawn.bytes(), needed + 170_000_000 + 7657 * 300);
    }

    #[test]
    fn a_cloud_is_averaged_at_as_many_places_as_fit() {
        let options = Options::default();
        let memory = Memory::of_cloud(1_000_000, &options);
        let places = |allowed| options.fitting(&memory, allowed).map(|o| o.cloud.most_places);
        assert_eq!(places(memory.bytes()).unwrap(), None);
        let fitting = places(1_000_000_000).unwrap().unwrap();
        assert!(memory.averaged(fitting, &options).bytes() <= 1_000_000_000);
        assert!(memory.averaged(fitting + 1, &options).bytes() > 1_000_000_000);
        assert!(places(200_000_000).is_err());
    }

    #[test]
    fn a_mesh_is_averaged_unless_each_vertex_counts() {
        let named = Options::builder().tolerance(0.1).build().unwrap();
        let memory = Memory::of_counts([1_000_000, 2_000_000], &Options::default());
        let places = |options: &Options, allowed| {
            options.fitting(&memory, allowed).map(|options| options.most_places())
        };
        let options = Options::default();
        assert_eq!(places(&options, memory.bytes()).unwrap(), None);
        let fitting = places(&options, 1_000_000_000).unwrap().unwrap();
        assert!(memory.averaged(fitting, &options).bytes() <= 1_000_000_000);
        assert!(memory.averaged(fitting + 1, &options).bytes() > 1_000_000_000);
        assert!(places(&options, 300_000_000).is_err());
        assert!(places(&named, 1_000_000_000).is_err());
    }

    #[test]
    fn counts_beyond_all_memory_do_not_overflow() {
        let options = Options::builder().net([4096, 4096]).max_net(1 << 24).build().unwrap();
        assert_eq!(Memory::of_counts([usize::MAX; 2], &options).bytes(), u64::MAX);
    }
}
