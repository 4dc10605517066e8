//! A scene as one mesh.

use super::{ColourRuns, NodeContent, Placement, Scene, SceneForm, SceneMesh, SceneNode};
use crate::limits::check_room;
use crate::{Error, Result, Soup};

/// The number of bytes that the soup may always have. More bytes are allowed only in proportion to
/// the size of the file, because a small file can contain many instances of one mesh.
const FREE: u64 = 24 << 20;
const PER_BYTE: u64 = 16;

/// The number of bytes that a soup of a file of so many bytes may have.
pub(crate) fn budget(bytes: u64) -> u64 {
    FREE.max(PER_BYTE.saturating_mul(bytes))
}

/// The number of bytes that points and triangles take in a soup.
pub(crate) fn soup_bytes(points: u64, triangles: u64) -> u64 {
    24 * points + 16 * triangles
}

impl Scene {
    /// All meshes in their places as one mesh, with every point and polygon of the file in its order.
    ///
    /// # Errors
    /// The nodes repeat their meshes so often that the result has many times the size of the file, or there are
    /// more points or corners than 32 bits count.
    pub fn into_soup(mut self) -> Result<Soup> {
        let colour = self.common_colour();
        if let [of_mesh] = self.meshes.as_mut_slice()
            && let [form] = self.forms.as_slice()
            && self.nodes.iter().filter(|node| node.content != NodeContent::Group).count() == 1
        {
            debug_assert_eq!(form.mesh.0, 0);
            let mut soup = std::mem::take(&mut of_mesh.soup);
            soup.colour = soup.colour.or(colour);
            if let Some(node) = self.nodes.iter().find(|node| node.content != NodeContent::Group) {
                place(&mut soup, node);
            }
            return Ok(soup);
        }
        self.check_expansion()?;
        let mut all = Soup {
            unit: self.unit,
            unit_comment: self.unit_comment.clone(),
            colour,
            ..Soup::default()
        };
        for (node, mesh) in self.placed() {
            check_room(
                &self.file,
                &all,
                mesh.soup.points.len() as u64,
                mesh.soup.polygons.corner_count() as u64,
            )?;
            let first = all.points.len() as u32;
            let placement = node.as_read.unwrap_or(Placement::IDENTITY);
            all.points.extend(mesh.soup.points.iter().map(|point| placement.apply(*point)));
            let flip = placement.mirrors();
            for polygon in mesh.soup.polygons.iter() {
                push(&mut all, polygon.iter().map(|corner| first + corner), flip);
            }
        }
        Ok(all)
    }

    /// All meshes in their places as one mesh with the colours of its polygons. `None` unless there are several.
    ///
    /// # Errors
    /// Those of [`into_soup`](Self::into_soup).
    pub fn painted(&self) -> Result<Option<SceneMesh>> {
        let (mut runs, mut count) = (ColourRuns::default(), 0);
        for (node, mesh) in self.placed() {
            let own = node.colour.or(mesh.colour).or(mesh.soup.colour);
            for (run, value) in mesh.colours.iter() {
                runs.extend_to(count + run.end, node.colour.or(mesh.colours.values()[value]));
            }
            count += mesh.soup.polygons.len();
            runs.extend_to(count, own);
        }
        let mut painted = SceneMesh::default();
        runs.give(&mut painted);
        if painted.colours.is_empty() {
            return Ok(None);
        }
        painted.soup = self.clone().into_soup()?;
        Ok(Some(painted))
    }

    /// The nodes with a mesh, and their meshes.
    pub(super) fn placed(&self) -> impl Iterator<Item = (&SceneNode, &SceneMesh)> {
        self.nodes.iter().filter_map(|node| match node.content {
            NodeContent::Group => None,
            NodeContent::Form(form) => {
                let SceneForm { mesh, .. } = self.forms[form.0];
                Some((node, &self.meshes[mesh.0]))
            }
        })
    }

    /// The colour that all places have, if there is one.
    fn common_colour(&self) -> Option<[u8; 3]> {
        let of_mesh = |mesh: &SceneMesh| match mesh.colours.is_empty() {
            true => mesh.colour,
            false => None,
        };
        let mut colours = self.placed().map(|(node, mesh)| node.colour.or(of_mesh(mesh)));
        let first = colours.next()??;
        colours.all(|colour| colour == Some(first)).then_some(first)
    }

    pub(super) fn check_expansion(&self) -> Result<()> {
        let of = |mesh: &SceneMesh| {
            soup_bytes(mesh.soup.points.len() as u64, mesh.soup.polygons.len() as u64)
        };
        let once: u64 = self.meshes.iter().map(of).sum();
        let all = self.placed().map(|(_, mesh)| of(mesh)).fold(0, u64::saturating_add);
        if all <= budget(self.bytes).max(once) {
            return Ok(());
        }
        let help = "Its nodes repeat their meshes excessively: export the scan alone.";
        Err(Error::new(&self.file, "expands to far more than it holds", help))
    }
}

/// Moves a mesh to its place.
fn place(soup: &mut Soup, node: &SceneNode) {
    let Some(placement) = node.as_read else { return };
    for point in &mut soup.points {
        *point = placement.apply(*point);
    }
    if placement.mirrors() {
        soup.polygons.turn_over();
    }
}

/// Adds a polygon, turned over if `flip`. Its first corner stays the first.
fn push(soup: &mut Soup, corners: impl DoubleEndedIterator<Item = u32>, flip: bool) {
    if !flip {
        return soup.polygons.push(corners);
    }
    let mut corners = corners;
    let first = corners.next();
    soup.polygons.push(first.into_iter().chain(corners.rev()));
}
