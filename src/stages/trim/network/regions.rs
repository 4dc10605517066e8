//! The faces that loops leave of the surfaces of a network.
//!
//! The arcs of all loops go in, each with the nodes at its ends. What is kept lies to the left of
//! an arc. So the outer loop of a face runs along an arc to its end, from there counter-clockwise
//! along the sides of the surface to the start of the next arc, and so on. A surface that no arc
//! meets is kept if its neighbour is kept up to their common side.

use std::collections::HashMap;

use crate::geometry::is_inside;
use crate::spline::{CutArc, CutPart, KeptFace, Network, NetworkCut, PieceEnd, chord_points};

/// A piece of a side of a surface, counter-clockwise: the number of the side and of the piece on
/// its track, and the ends.
type SidePiece = (usize, usize, [PieceEnd; 2]);

/// Adds the kept faces to a cut that has its nodes and its arcs. Returns a surface on which the arcs do
/// not bound faces if there is one: they cross each other, or a loop runs the wrong way around.
pub(crate) fn add_faces(network: &Network, cut: &mut NetworkCut) -> Result<(), usize> {
    let ends = cut.piece_ends(network);
    let around = |surface: usize| -> Vec<SidePiece> {
        let sides = network.sides[surface].iter().enumerate();
        let pieces = sides.flat_map(|(k, side)| {
            let ends = &ends[side.track];
            let count = ends.len() - 1;
            (0..count).map(move |i| {
                let piece = if side.forward { i } else { count - 1 - i };
                let mut of = [ends[piece].1, ends[piece + 1].1];
                if !side.forward {
                    of.reverse();
                }
                (k, piece, of)
            })
        });
        pieces.collect()
    };
    let mut arcs_of: Vec<Vec<usize>> = vec![Vec::new(); network.surfaces.len()];
    let mut loops_of = arcs_of.clone();
    for (number, arc) in cut.arcs.iter().enumerate() {
        let of = if arc.ends.is_some() { &mut arcs_of } else { &mut loops_of };
        of[arc.surface].push(number);
    }
    // For each piece of a track, whether a surface keeps it.
    let mut kept: HashMap<(usize, usize), bool> = HashMap::new();
    let mut keep = |surface: usize, k: usize, piece: usize, is_kept: bool| {
        let track = network.sides[surface][k].track;
        *kept.entry((track, piece)).or_insert(is_kept) == is_kept
    };
    let mut todo = Vec::new();
    for surface in 0..network.surfaces.len() {
        let pieces = around(surface);
        let outer = match arcs_of[surface].is_empty() {
            false => outer_loops(&pieces, &arcs_of[surface], &cut.arcs).ok_or(surface)?,
            true if loops_of[surface].is_empty() => continue,
            true => vec![pieces.iter().map(|&(k, piece, _)| CutPart::Side(k, piece)).collect()],
        };
        for &(k, piece, _) in &pieces {
            let is_kept = outer.iter().any(|parts| parts.contains(&CutPart::Side(k, piece)));
            keep(surface, k, piece, is_kept).then_some(()).ok_or(surface)?;
        }
        todo.push(surface);
        cut.faces.extend(outer.into_iter().map(|parts| KeptFace { surface, loops: vec![parts] }));
    }
    spread(network, &mut cut.faces, &mut todo, keep)?;
    let mut loops = loops_of.into_iter().flatten();
    loops.try_for_each(|number| put_in(network, cut, number).ok_or(cut.arcs[number].surface))
}

/// The outer loops of the faces of one surface.
fn outer_loops(pieces: &[SidePiece], own: &[usize], arcs: &[CutArc]) -> Option<Vec<Vec<CutPart>>> {
    let starts: HashMap<usize, usize> =
        own.iter().filter_map(|&arc| Some((arcs[arc].ends?[0], arc))).collect();
    let mut loops = Vec::new();
    let mut open: Vec<usize> = own.to_vec();
    while let Some(&first) = open.first() {
        let mut parts = Vec::new();
        let mut arc = first;
        loop {
            let place = open.iter().position(|&other| other == arc)?;
            open.remove(place);
            parts.push(CutPart::Arc(arc));
            let mut node = PieceEnd::Node(arcs[arc].ends?[1]);
            // Along the sides to the start of the next arc.
            arc = loop {
                let &(k, piece, [_, end]) = pieces.iter().find(|piece| piece.2[0] == node)?;
                parts.push(CutPart::Side(k, piece));
                node = end;
                match node {
                    PieceEnd::Node(number) => break *starts.get(&number)?,
                    PieceEnd::Corner(_) if parts.len() > own.len() + 2 * pieces.len() => {
                        return None;
                    }
                    PieceEnd::Corner(_) => {}
                }
            };
            if arc == first {
                break;
            }
        }
        loops.push(parts);
    }
    Some(loops)
}

/// Adds the whole surfaces that are beside kept faces, and those beside these.
fn spread(
    network: &Network,
    faces: &mut Vec<KeptFace>,
    todo: &mut Vec<usize>,
    mut keep: impl FnMut(usize, usize, usize, bool) -> bool,
) -> Result<(), usize> {
    let uses = network.uses();
    let mut is_done = vec![false; network.surfaces.len()];
    todo.iter().for_each(|&surface| is_done[surface] = true);
    let mut next = 0;
    while let Some(&surface) = todo.get(next) {
        next += 1;
        for k in 0..4 {
            let track = network.sides[surface][k].track;
            for side in uses[track].iter().filter(|side| !is_done[side.face]).collect::<Vec<_>>() {
                if is_done[side.face] || !keep(side.face, side.k, 0, true) {
                    continue;
                }
                is_done[side.face] = true;
                for k in 0..4 {
                    keep(side.face, k, 0, true).then_some(()).ok_or(side.face)?;
                }
                let sides = (0..4).map(|k| CutPart::Side(k, 0)).collect();
                faces.push(KeptFace { surface: side.face, loops: vec![sides] });
                todo.push(side.face);
            }
        }
    }
    Ok(())
}

/// Adds a loop on one surface to the face that it is in.
fn put_in(network: &Network, cut: &mut NetworkCut, number: usize) -> Option<()> {
    let surface = cut.arcs[number].surface;
    let start = chord_points(&cut.arcs[number].pcurves).first().copied()?;
    let of_surface = (0..cut.faces.len()).filter(|&face| cut.faces[face].surface == surface);
    let is_around = |face: &usize| {
        let outer = cut.boundary(network, &cut.faces[*face]).swap_remove(0);
        is_inside(start, &chord_points(&outer))
    };
    let face = of_surface.into_iter().find(is_around)?;
    cut.faces[face].loops.push(vec![CutPart::Arc(number)]);
    Some(())
}
