//! Reader of the items of representations: bodies, shells, and sets of surfaces.

use super::topology::TopologyReader;
use crate::Result;
use crate::cad::{CadEdge, CadModel, CadSolid};

impl TopologyReader<'_, '_> {
    /// Adds the faces of an item of a representation. Items without faces, such as placements and
    /// points, add nothing.
    pub(super) fn item(&mut self, id: u64, model: &mut CadModel) -> Result<()> {
        let entity = self.file.entity(id)?;
        if entity.records.len() > 1 {
            let is_shape = |name: &str| {
                name.ends_with("BREP") || name.ends_with("_FACE") || name.ends_with("SHELL")
            };
            return match entity.records.iter().find(|record| is_shape(record.name)) {
                Some(record) => Err(self.unread_item(id, record.name)),
                None => Ok(()),
            };
        }
        let (kind, mut attributes) = self.file.simple(id)?;
        match kind {
            "SHELL_BASED_SURFACE_MODEL" | "FACE_BASED_SURFACE_MODEL" => {
                attributes.skip(1)?;
                for shell in attributes.references()? {
                    self.shell(shell, model)?;
                }
                Ok(())
            }
            "MANIFOLD_SOLID_BREP" | "FACETED_BREP" | "BREP_WITH_VOIDS" => {
                attributes.skip(1)?;
                let outer = self.shell(attributes.reference()?, model)?;
                let mut voids = Vec::new();
                if kind == "BREP_WITH_VOIDS" {
                    for shell in attributes.references()? {
                        voids.push(self.shell(shell, model)?);
                    }
                }
                // Several representations may hold one solid.
                if self.seen.solids.insert(id) {
                    model.solids.push(CadSolid { outer, voids });
                }
                Ok(())
            }
            "OPEN_SHELL"
            | "CLOSED_SHELL"
            | "CONNECTED_FACE_SET"
            | "ORIENTED_OPEN_SHELL"
            | "ORIENTED_CLOSED_SHELL" => self.shell(id, model).map(drop),
            "ADVANCED_FACE" | "FACE_SURFACE" | "FACE" | "ORIENTED_FACE" => {
                self.face(id, model).map(drop)
            }
            "GEOMETRIC_SET" => {
                attributes.skip(1)?;
                for element in attributes.references()? {
                    self.element(element, model)?;
                }
                Ok(())
            }
            // Assemblies read these.
            "MAPPED_ITEM" => Ok(()),
            kind if is_shapeless(kind) => Ok(()),
            kind => Err(self.unread_item(id, kind)),
        }
    }

    fn unread_item(&self, id: u64, kind: &str) -> crate::Error {
        self.file.unread(id, format!("is an item of an unsupported kind: {kind}"))
    }

    /// Adds a surface of a geometric set.
    fn element(&mut self, id: u64, model: &mut CadModel) -> Result<()> {
        let is_surface =
            |name: &str| name.ends_with("SURFACE") || name.starts_with("B_SPLINE_SURFACE");
        let entity = self.file.entity(id)?;
        let Some(record) = entity.records.iter().find(|record| is_surface(record.name)) else {
            return if entity.records.len() == 1 { self.item(id, model) } else { Ok(()) };
        };
        let kind = record.name;
        if self.seen.faces.contains_key(&id) {
            return Ok(());
        }
        self.seen.faces.insert(id, model.faces.len());
        if kind == "RECTANGULAR_COMPOSITE_SURFACE" {
            return self.patches(id, model);
        }
        if kind == "CURVE_BOUNDED_SURFACE" {
            return self.bounded_by_curves(id, model);
        }
        let surface = self.surface(id)?;
        self.push(id, (surface, true, Some(true)), Vec::new(), model)
    }

    /// Adds the patches of a rectangular composite surface.
    fn patches(&mut self, id: u64, model: &mut CadModel) -> Result<()> {
        let mut attributes = self.file.of_type(id, "RECTANGULAR_COMPOSITE_SURFACE")?;
        attributes.skip(1)?;
        for patch in attributes.rows()?.into_iter().flatten() {
            let parent = self.file.of_type(patch, "SURFACE_PATCH")?.reference()?;
            let surface = self.surface(parent)?;
            self.push(parent, (surface, true, Some(true)), Vec::new(), model)?;
        }
        Ok(())
    }

    /// Adds a surface that curves bound.
    fn bounded_by_curves(&mut self, id: u64, model: &mut CadModel) -> Result<()> {
        let mut attributes = self.file.of_type(id, "CURVE_BOUNDED_SURFACE")?;
        attributes.skip(1)?;
        let basis = self.geometry.basis(attributes.reference()?)?;
        let boundaries = attributes.references()?;
        let natural = attributes.logical()?;
        let mut loops = Vec::with_capacity(boundaries.len());
        for boundary in boundaries {
            loops.push(self.boundary(boundary, basis)?);
        }
        let surface = self.surface(basis)?;
        self.push(id, (surface, natural, None), loops, model)
    }

    /// The edges of a boundary curve.
    fn boundary(&self, id: u64, surface: u64) -> Result<Vec<CadEdge>> {
        let (kind, mut attributes) = self.file.simple(id)?;
        if !matches!(
            kind,
            "BOUNDARY_CURVE"
                | "OUTER_BOUNDARY_CURVE"
                | "COMPOSITE_CURVE_ON_SURFACE"
                | "COMPOSITE_CURVE"
        ) {
            return Err(self.unread_item(id, kind));
        }
        attributes.skip(1)?;
        let segments = attributes.references()?;
        self.file.spend(id, segments.len())?;
        let mut edges = Vec::with_capacity(segments.len());
        for segment in segments {
            let mut segment = self.file.of_type(segment, "COMPOSITE_CURVE_SEGMENT")?;
            segment.skip(1)?;
            let forward = segment.logical()?;
            let (curve, pcurves) = self.edge_geometry(segment.reference()?)?;
            let pcurves = pcurves.get(&surface).into_iter().flatten().cloned().collect();
            edges.push(CadEdge { curve, ends: None, forward, pcurves, pcurve_forward: forward });
        }
        Ok(edges)
    }
}

/// Whether an item has no faces, and is no part of a shape.
fn is_shapeless(kind: &str) -> bool {
    const WHOLE: [&str; 13] = [
        "CIRCLE",
        "DIRECTION",
        "ELLIPSE",
        "EDGE_BASED_WIREFRAME_MODEL",
        "GEOMETRIC_CURVE_SET",
        "HYPERBOLA",
        "LINE",
        "PARABOLA",
        "PLANE",
        "POLYLINE",
        "SHELL_BASED_WIREFRAME_MODEL",
        "STYLED_ITEM",
        "VECTOR",
    ];
    // Placements, points, curves, what annotates a shape, and triangles that go with the exact faces.
    let begins =
        ["ANNOTATION", "AXIS", "CAMERA", "COMPLEX_TRIANGULATED", "COORDINATES", "TESSELLATED"];
    let begins_too = ["DRAUGHTING", "REPOSITIONED_TESSELLATED", "TRIANGULATED"];
    let ends =
        ["_CURVE", "_CURVE_WITH_KNOTS", "_LOOP", "_POINT", "_REPLICA", "REPRESENTATION_ITEM"];
    let more_ends = ["EDGE_CURVE", "MEASURE_WITH_UNIT", "OPERATOR_3D", "WIRE_SHELL", "_PLACEMENT"];
    WHOLE.contains(&kind)
        || begins.iter().chain(&begins_too).any(|begin| kind.starts_with(begin))
        || ends.iter().chain(&more_ends).any(|end| kind.ends_with(end))
}
