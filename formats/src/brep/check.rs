//! Checks of a boundary representation before it is written.
//!
//! The input is a [`Brep`]. The output is the first [`ModelFault`], if there is one.

use super::{Brep, BrepElement, BrepSurface, EdgeId, FaceId, ModelFault, Shell, ShellId, Solid};

/// Nothing, or the first fault.
pub(super) type Checked = Result<(), ModelFault>;

impl Brep {
    /// Checks the model:
    ///
    /// - Every number refers to an existing element, and every face belongs to one shell.
    ///   Coordinates are finite, and knots are clamped.
    /// - Every edge ends at its vertices. It agrees with each of its pcurves on the surface within
    ///   the uncertainty.
    /// - The measures of surfaces are valid.
    /// - Every loop is closed in space and in the parameter plane, stays in the range of the
    ///   surface, and has the right orientation. In the parameter plane it may be open at a pole or
    ///   an apex. A face spans at most one period.
    /// - The faces of a shell are connected and have the same orientation. An edge is used once or
    ///   twice in an open shell, and twice in opposite directions in a closed shell. A closed shell
    ///   has the Euler number of a closed surface.
    /// - The shells of a solid are closed and face outwards from the material. Its voids are in the
    ///   bounding box of its outer shell.
    ///
    /// It does not check whether loops or faces cross each other.
    ///
    /// # Errors
    /// The first fault that is found.
    pub fn check(&self) -> Result<(), ModelFault> {
        if self.faces.is_empty() {
            return Err(ModelFault::Empty);
        }
        if !(self.uncertainty_mm.is_finite() && self.uncertainty_mm > 0.0) {
            return Err(ModelFault::Uncertainty(self.uncertainty_mm));
        }
        self.check_numbers()?;
        self.check_owners()?;
        self.check_geometry()?;
        for (number, face) in self.faces.iter().enumerate() {
            self.check_face(number, face)?;
        }
        self.check_shells()?;
        self.solids.iter().enumerate().try_for_each(|(n, solid)| self.check_solid(n, solid))
    }

    /// The faults of the loops of faces, one for each face that has some. All numbers must refer to existing elements.
    pub fn face_faults(&self) -> Vec<(FaceId, ModelFault)> {
        let fault = |(n, face)| self.check_face(n, face).err().map(|fault| (FaceId(n), fault));
        self.faces.iter().enumerate().filter_map(fault).collect()
    }

    /// Checks that all numbers refer to existing elements.
    fn check_numbers(&self) -> Checked {
        let there = |by: BrepElement, named: BrepElement, is: bool| match is {
            true => Ok(()),
            false => Err(ModelFault::Missing(by, named)),
        };
        for (n, edge) in self.edges.iter().enumerate() {
            for end in edge.ends {
                let is = end.0 < self.vertices.len();
                there(BrepElement::Edge(n), BrepElement::Vertex(end.0), is)?;
            }
        }
        for (n, face) in self.faces.iter().enumerate() {
            let is = face.surface.0 < self.surfaces.len();
            there(BrepElement::Face(n), BrepElement::Surface(face.surface.0), is)?;
            for EdgeId(edge) in face.loops.iter().flatten().map(|of_loop| of_loop.edge) {
                there(BrepElement::Face(n), BrepElement::Edge(edge), edge < self.edges.len())?;
            }
        }
        for (n, shell) in self.shells.iter().enumerate() {
            for FaceId(face) in &shell.faces {
                there(BrepElement::Shell(n), BrepElement::Face(*face), *face < self.faces.len())?;
            }
        }
        for (n, solid) in self.solids.iter().enumerate() {
            for ShellId(shell) in solid.shells() {
                there(BrepElement::Solid(n), BrepElement::Shell(shell), shell < self.shells.len())?;
            }
        }
        Ok(())
    }

    /// Checks that every face belongs to one shell, and every shell to at most one solid.
    fn check_owners(&self) -> Checked {
        let mut faces = vec![0; self.faces.len()];
        self.shells.iter().flat_map(|shell| &shell.faces).for_each(|face| faces[face.0] += 1);
        if let Some(face) = faces.iter().position(|&owners| owners != 1) {
            return Err(ModelFault::Owners(BrepElement::Face(face), faces[face]));
        }
        let mut shells = vec![0; self.shells.len()];
        self.solids.iter().flat_map(Solid::shells).for_each(|shell| shells[shell.0] += 1);
        match shells.iter().position(|&owners| owners > 1) {
            Some(shell) => Err(ModelFault::Owners(BrepElement::Shell(shell), shells[shell])),
            None => Ok(()),
        }
    }

    /// Checks that coordinates are finite, knots are clamped, and edges end at their vertices.
    fn check_geometry(&self) -> Checked {
        let finite = |vertex: &[f64; 3]| vertex.iter().all(|x| x.is_finite());
        if let Some(vertex) = self.vertices.iter().position(|vertex| !finite(vertex)) {
            return Err(ModelFault::NotFinite(BrepElement::Vertex(vertex)));
        }
        for (n, surface) in self.surfaces.iter().enumerate() {
            self.check_surface(BrepElement::Surface(n), surface)?;
        }
        for (n, edge) in self.edges.iter().enumerate() {
            let curve = &edge.curve;
            if curve.spline().is_some_and(|spline| !spline.knots().are_clamped()) {
                return Err(ModelFault::Unclamped(BrepElement::Edge(n)));
            }
            for (end, vertex) in curve.ends().into_iter().zip(edge.ends) {
                let off = distance(end, self.vertices[vertex.0]);
                if off > self.uncertainty_mm {
                    return Err(ModelFault::Vertex(BrepElement::Edge(n), off));
                }
            }
        }
        Ok(())
    }

    /// Checks that the knots of a surface are clamped, and that its measures are valid.
    fn check_surface(&self, part: BrepElement, surface: &BrepSurface) -> Checked {
        let clamped = match surface {
            BrepSurface::Spline(spline) => spline.u().are_clamped() && spline.v().are_clamped(),
            BrepSurface::Extrusion { profile, .. } | BrepSurface::Revolution { profile, .. } => {
                profile.knots().are_clamped()
            }
            _ => true,
        };
        match surface.fault() {
            _ if !clamped => Err(ModelFault::Unclamped(part)),
            Some(fault) => Err(ModelFault::Measures(part, fault)),
            None => Ok(()),
        }
    }

    /// Checks that the faces of each shell share edges correctly.
    fn check_shells(&self) -> Checked {
        let mut shell_of = vec![0; self.faces.len()];
        for (n, shell) in self.shells.iter().enumerate() {
            shell.faces.iter().for_each(|face| shell_of[face.0] = n);
        }
        let mut pieces = FaceGroups::new(self.faces.len());
        for (edge, uses) in self.uses().into_iter().enumerate() {
            let Some(&(first, _)) = uses.first() else { continue };
            let shell = ShellId(shell_of[first.0]);
            if uses.iter().any(|(face, _)| shell_of[face.0] != shell.0) {
                return Err(ModelFault::Shared(BrepElement::Edge(edge)));
            }
            let closed = self.shells[shell.0].closed;
            match uses[..] {
                [_] if !closed => {}
                [(a, of_a), (b, of_b)] => {
                    if of_a.forward == of_b.forward {
                        return Err(ModelFault::Turned { faces: [a, b], edge: EdgeId(edge) });
                    }
                    pieces.join(a.0, b.0);
                }
                _ => return Err(ModelFault::Uses { shell, edge: EdgeId(edge), uses: uses.len() }),
            }
        }
        for (n, shell) in self.shells.iter().enumerate() {
            self.check_shell(n, shell, &mut pieces)?;
        }
        Ok(())
    }

    /// Checks that a shell is connected, and that it is closed if it is declared closed.
    fn check_shell(&self, number: usize, shell: &Shell, pieces: &mut FaceGroups) -> Checked {
        let Some(first) = shell.faces.first() else {
            return Err(ModelFault::Nothing(BrepElement::Shell(number)));
        };
        let head = pieces.head(first.0);
        if shell.faces.iter().any(|face| pieces.head(face.0) != head) {
            return Err(ModelFault::Pieces(BrepElement::Shell(number)));
        }
        if !shell.closed {
            return Ok(());
        }
        let faces = || shell.faces.iter().map(|face| &self.faces[face.0]);
        let uses = faces().flat_map(|face| face.loops.iter().flatten());
        let mut edges: Vec<EdgeId> = uses.map(|of_loop| of_loop.edge).collect();
        edges.sort_unstable();
        edges.dedup();
        let mut vertices: Vec<_> = edges.iter().flat_map(|e| self.edges[e.0].ends).collect();
        vertices.sort_unstable();
        vertices.dedup();
        // A face with n inner loops is a disk minus n disks.
        let disks: i64 = faces().map(|face| 2 - face.loops.len() as i64).sum();
        let euler = vertices.len() as i64 - edges.len() as i64 + disks;
        if euler > 2 || euler % 2 != 0 {
            return Err(ModelFault::Euler(BrepElement::Shell(number), euler));
        }
        Ok(())
    }

    /// Checks that the shells of a solid are closed and face outwards from its material.
    fn check_solid(&self, number: usize, solid: &Solid) -> Checked {
        let [part, outer] = [BrepElement::Solid(number), BrepElement::Shell(solid.outer.0)];
        let around = self.bounds(solid.outer);
        for shell in solid.shells() {
            let of_solid = BrepElement::Shell(shell.0);
            if !self.shells[shell.0].closed {
                return Err(ModelFault::OpenShell(part, of_solid));
            }
            let is_outer = shell == solid.outer;
            if (self.volume(shell) > 0.0) != is_outer {
                return Err(ModelFault::InsideOut(of_solid, part));
            }
            // The edges lie in the material for certain. The box of the faces may be too large.
            let [low, high] = self.edge_bounds(shell);
            let inside = (0..3).all(|k| around[0][k] < low[k] && high[k] < around[1][k]);
            if !is_outer && !inside {
                return Err(ModelFault::Outside(of_solid, outer));
            }
        }
        Ok(())
    }
}

/// Groups of connected faces as disjoint sets. Each face refers to an earlier face of its group,
/// and the first one refers to itself.
struct FaceGroups(Vec<usize>);

impl FaceGroups {
    fn new(faces: usize) -> Self {
        FaceGroups((0..faces).collect())
    }

    /// The first face of a face's group. The path to it is shortened.
    fn head(&mut self, mut face: usize) -> usize {
        while self.0[face] != face {
            self.0[face] = self.0[self.0[face]];
            face = self.0[face];
        }
        face
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.head(a), self.head(b));
        self.0[a.max(b)] = a.min(b);
    }
}

pub(super) fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let square: f64 = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum();
    // A distance that is not a number counts as infinite.
    if square.is_nan() { f64::INFINITY } else { square.sqrt() }
}
