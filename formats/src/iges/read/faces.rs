//! Reader of trimmed surfaces (144) and of the faces of shells (514).

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::deck::Deck;
use super::geometry::IgesGeometry;
use super::parameters::Parameters;
use super::shape::converted;
use crate::Result;
use crate::cad::affine::Affine;
use crate::cad::{CadEdge, CadFace, CadModel, CadPlace, CadShell, CadSurface};

/// Reads faces.
pub(super) struct FaceReader<'d> {
    deck: &'d Deck<'d>,
    geometry: IgesGeometry<'d>,
    edge_lists: HashMap<i64, Vec<ListedEdge>>,
    vertex_lists: HashMap<i64, Vec<[f64; 3]>>,
    /// The faces (510) that have been read.
    faces: HashSet<i64>,
}

/// An edge of an edge list (504).
#[derive(Clone, Copy)]
struct ListedEdge {
    curve: i64,
    ends: [[f64; 3]; 2],
}

impl<'d> FaceReader<'d> {
    pub(super) fn new(deck: &'d Deck<'d>) -> Self {
        FaceReader {
            deck,
            geometry: IgesGeometry::new(deck),
            edge_lists: HashMap::new(),
            vertex_lists: HashMap::new(),
            faces: HashSet::new(),
        }
    }

    /// The placement of an entity.
    pub(super) fn place(&self, pointer: i64, outer: &Affine) -> Result<Affine> {
        self.geometry.place(pointer, outer)
    }

    /// Reads an independent surface, for example entity 128, as a face with the boundary of the
    /// surface.
    pub(super) fn whole(&mut self, pointer: i64, unit: &Affine) -> Result<CadFace> {
        let surface = self.geometry.surface(pointer, unit)?;
        Ok(face(pointer, surface, (true, None), Vec::new()))
    }

    /// Reads a trimmed surface (144).
    pub(super) fn trimmed(&mut self, pointer: i64, unit: &Affine) -> Result<CadFace> {
        let place = self.geometry.place(pointer, unit)?;
        let mut p = self.deck.parameters(pointer)?;
        let surface = p.integer()?;
        let (outer, inner) = (p.integer()?, p.count()?);
        let first = p.integer()?;
        let mut loops = Vec::new();
        if outer != 0 {
            loops.push(self.on_surface(first, &place)?);
        }
        for inner in p.several(inner, Parameters::integer)? {
            loops.push(self.on_surface(inner, &place)?);
        }
        self.convert_parameters(surface, &mut loops)?;
        let surface = self.geometry.surface(surface, &place)?;
        Ok(face(pointer, surface, (outer == 0, None), loops))
    }

    /// Reads a bounded surface (143).
    pub(super) fn bounded(&mut self, pointer: i64, unit: &Affine) -> Result<CadFace> {
        let place = self.geometry.place(pointer, unit)?;
        let mut p = self.deck.parameters(pointer)?;
        p.skip(1);
        let (surface, count) = (p.integer()?, p.count()?);
        let boundaries = p.several(count, Parameters::integer)?;
        let loops = boundaries.into_iter().map(|boundary| self.boundary(boundary, &place));
        let mut loops: Vec<Vec<CadEdge>> = loops.collect::<Result<_>>()?;
        self.convert_parameters(surface, &mut loops)?;
        let surface = self.geometry.surface(surface, &place)?;
        Ok(face(pointer, surface, (loops.is_empty(), None), loops))
    }

    /// Reads the loop of a bounded surface (141): curves in space, which may run against the loop, each with its pcurves,
    /// which run with the loop.
    fn boundary(&mut self, pointer: i64, outer: &Affine) -> Result<Vec<CadEdge>> {
        let mut p = self.geometry.of_kind(pointer, 141, "a boundary")?;
        p.skip(3);
        let count = p.count()?;
        let uses = p.several(count, |p| {
            let (curve, is_against) = (p.integer()?, p.integer()? == 2);
            let flat = p.count()?;
            Ok((curve, is_against, p.several(flat, Parameters::integer)?))
        })?;
        let place = self.geometry.place(pointer, outer)?;
        let mut edges = Vec::new();
        for (curve, is_against, flat) in uses {
            let mut curves = self.geometry.curves(curve, &place)?;
            if is_against {
                curves.reverse();
            }
            let flat = flat.into_iter().map(|pcurve| self.geometry.pcurves(pcurve));
            let pcurves = flat.collect::<Result<Vec<_>>>()?.concat();
            let are_paired = curves.len() == pcurves.len();
            for (i, curve) in curves.into_iter().enumerate() {
                let pcurves = if are_paired { vec![pcurves[i].clone()] } else { Vec::new() };
                edges.push(CadEdge {
                    curve: Some(curve),
                    ends: None,
                    forward: !is_against,
                    pcurves,
                    pcurve_forward: true,
                });
            }
        }
        Ok(edges)
    }

    /// Converts pcurves to the parameters of the model's surface.
    fn convert_parameters(&self, surface: i64, loops: &mut [Vec<CadEdge>]) -> Result<()> {
        let kind = self.deck.entry(surface)?.kind;
        // OpenCASCADE takes the second parameter of a cone as the length along the cone, and so do
        // we.
        let slant = if kind == 194 { self.geometry.cosine(surface)? } else { 1.0 };
        let there = |[u, v]: [f64; 2]| match kind {
            // Angles are in degrees.
            192 | 194 => [u.to_radians(), v * slant],
            196 => [u.to_radians(), v.to_radians()],
            // The first parameter goes around the tube, and the second one backwards.
            198 => [(360.0 - v).to_radians(), u.to_radians()],
            // The first parameter is that of the curve.
            120 => [v, u],
            _ => [u, v],
        };
        if matches!(kind, 120 | 192 | 194 | 196 | 198) {
            let pcurves = loops.iter_mut().flatten().flat_map(|edge| &mut edge.pcurves);
            pcurves.for_each(|pcurve| *pcurve = Arc::new(converted(pcurve, there)));
        }
        Ok(())
    }

    /// Reads a loop (142). It has pcurves or curves in space. It has both if their numbers are
    /// equal.
    fn on_surface(&mut self, pointer: i64, outer: &Affine) -> Result<Vec<CadEdge>> {
        let found = self.deck.entry(pointer)?.kind;
        if found != 142 {
            let what = format!("is of type {found} where a curve on a surface (142) is expected");
            return Err(self.deck.error(pointer, what));
        }
        let mut p = self.deck.parameters(pointer)?;
        p.skip(2);
        let (flat, space) = (p.integer()?, p.integer()?);
        let place = self.geometry.place(pointer, outer)?;
        let curves = if space == 0 { Vec::new() } else { self.geometry.curves(space, &place)? };
        let pcurves = if flat == 0 { Vec::new() } else { self.geometry.pcurves(flat)? };
        let edge = |curve, pcurves| CadEdge {
            curve,
            ends: None,
            forward: true,
            pcurves,
            pcurve_forward: true,
        };
        if curves.len() == pcurves.len() {
            let both = curves.into_iter().zip(pcurves);
            return Ok(both.map(|(curve, pcurve)| edge(Some(curve), vec![pcurve])).collect());
        }
        if pcurves.is_empty() {
            return Ok(curves.into_iter().map(|curve| edge(Some(curve), Vec::new())).collect());
        }
        Ok(pcurves.into_iter().map(|pcurve| edge(None, vec![pcurve])).collect())
    }

    /// The shells of a solid (186). The outer one comes first.
    pub(super) fn shells(&self, pointer: i64) -> Result<Vec<i64>> {
        let mut p = self.deck.parameters(pointer)?;
        let mut shells = vec![p.integer()?];
        p.skip(1);
        let voids = p.count()?;
        shells.extend(p.several(voids, |p| p.integer().inspect(|_| p.skip(1)))?);
        Ok(shells)
    }

    /// Adds a shell (514) and its faces, and returns its number.
    pub(super) fn shell(
        &mut self,
        pointer: i64,
        outer: &Affine,
        model: &mut CadModel,
    ) -> Result<usize> {
        let place = self.geometry.place(pointer, outer)?;
        let mut p = self.deck.parameters(pointer)?;
        let count = p.count()?;
        let faces = p.several(count, |p| Ok((p.integer()?, p.integer()?)))?;
        let first = model.faces.len();
        let inverted = faces.iter().map(|(_, along)| *along == 0).collect();
        for (face, _) in faces {
            model.faces.push(self.face(face, &place)?);
        }
        let closed = self.deck.entry(pointer)?.form == 1;
        let faces = (first..model.faces.len()).collect();
        model.shells.push(CadShell { faces, inverted, closed });
        Ok(model.shells.len() - 1)
    }

    /// Whether a face (510) has been read.
    pub(super) fn is_read(&self, pointer: i64) -> bool {
        self.faces.contains(&pointer)
    }

    /// Reads a face (510).
    pub(super) fn face(&mut self, pointer: i64, outer: &Affine) -> Result<CadFace> {
        let found = self.deck.entry(pointer)?.kind;
        if found != 510 {
            let what = format!("is of type {found} where a face (510) is expected");
            return Err(self.deck.error(pointer, what));
        }
        self.faces.insert(pointer);
        let place = self.geometry.place(pointer, outer)?;
        let mut p = self.deck.parameters(pointer)?;
        let surface = p.integer()?;
        let count = p.count()?;
        p.skip(1);
        let loops = p.several(count, Parameters::integer)?;
        let mut loops: Vec<Vec<CadEdge>> =
            loops.into_iter().map(|l| self.edge_loop(l, &place)).collect::<Result<_>>()?;
        self.convert_parameters(surface, &mut loops)?;
        // The parameters of a surface of revolution are exchanged, so its normal is the opposite one.
        let forward = self.deck.entry(surface)?.kind != 120;
        let surface = self.geometry.surface(surface, &place)?;
        Ok(face(pointer, surface, (count == 0, Some(forward)), loops))
    }

    /// Reads a loop (508).
    fn edge_loop(&mut self, pointer: i64, place: &Affine) -> Result<Vec<CadEdge>> {
        let mut p = self.deck.parameters(pointer)?;
        let count = p.count()?;
        let uses = p.several(count, |p| {
            let (vertex, list, index) = (p.integer()?, p.integer()?, p.count()?);
            let forward = p.integer()? != 0;
            let count = p.count()?;
            let pcurves = p.several(count, |p| {
                p.skip(1);
                p.integer()
            })?;
            Ok((vertex, list, index, forward, pcurves))
        })?;
        let mut edges = Vec::with_capacity(uses.len());
        for (vertex, list, index, forward, pcurves) in uses {
            if vertex == 1 {
                continue; // a pole, where the loop jumps
            }
            let ListedEdge { curve, ends } = self.edge(list, index)?;
            let curves = self.geometry.curves(curve, place)?;
            let [curve] = &curves[..] else {
                return Err(self.deck.unread(curve, "is an edge of several curves"));
            };
            let pcurves = match pcurves[..] {
                [pcurve] => self.geometry.pcurves(pcurve)?,
                _ => Vec::new(),
            };
            edges.push(CadEdge {
                curve: Some(curve.clone()),
                ends: Some(ends.map(|end| place.point(end))),
                forward,
                // A pcurve in several pieces is computed anew later.
                pcurves: if pcurves.len() == 1 { pcurves } else { Vec::new() },
                // Pcurves have the direction of the loop, even if the edge has the opposite
                // direction.
                pcurve_forward: true,
            });
        }
        Ok(edges)
    }

    /// An edge of an edge list (504), counted from 1.
    fn edge(&mut self, list: i64, index: usize) -> Result<ListedEdge> {
        if !self.edge_lists.contains_key(&list) {
            let edges = self.edge_list(list)?;
            self.edge_lists.insert(list, edges);
        }
        self.nth(list, &self.edge_lists[&list], index, "edge")
    }

    fn nth<T: Copy>(&self, list: i64, items: &[T], index: usize, what: &str) -> Result<T> {
        let item = index.checked_sub(1).and_then(|i| items.get(i)).copied();
        item.ok_or_else(|| self.deck.error(list, format!("has no {what} {index}")))
    }

    fn edge_list(&mut self, pointer: i64) -> Result<Vec<ListedEdge>> {
        let mut p = self.deck.parameters(pointer)?;
        let count = p.count()?;
        let rows = p.several(count, |p| {
            Ok((p.integer()?, [(p.integer()?, p.count()?), (p.integer()?, p.count()?)]))
        })?;
        let mut edges = Vec::with_capacity(rows.len());
        for (curve, [start, end]) in rows {
            edges.push(ListedEdge { curve, ends: [self.vertex(start)?, self.vertex(end)?] });
        }
        Ok(edges)
    }

    /// A vertex of a vertex list (502), counted from 1.
    fn vertex(&mut self, (list, index): (i64, usize)) -> Result<[f64; 3]> {
        if !self.vertex_lists.contains_key(&list) {
            let mut p = self.deck.parameters(list)?;
            let count = p.count()?;
            self.vertex_lists.insert(list, p.several(count, Parameters::point)?);
        }
        self.nth(list, &self.vertex_lists[&list], index, "vertex")
    }
}

/// A face of the model at its own place. `bounds` say whether its outer boundary is that of its surface, and which
/// way its loops run.
fn face(
    pointer: i64,
    surface: Arc<CadSurface>,
    (natural, forward): (bool, Option<bool>),
    loops: Vec<Vec<CadEdge>>,
) -> CadFace {
    let places = Arc::new([CadPlace::same()]);
    CadFace { entity: name(pointer), surface, natural, forward, loops, places }
}

fn name(pointer: i64) -> String {
    format!("directory entry {pointer}")
}
