//! Values of polygons that follow each other.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{SceneMesh, SceneNote, clean_name};

/// A value for each polygon, held once for consecutive polygons that share it. Nothing is held if no polygon has a value.
#[derive(Debug, Clone, PartialEq)]
pub struct PolygonRuns<T> {
    /// The values.
    values: Vec<T>,
    /// The number of the polygon after the last one of each run, and the number of its value.
    runs: Vec<(u32, u32)>,
}

impl<T> Default for PolygonRuns<T> {
    fn default() -> Self {
        PolygonRuns { values: Vec::new(), runs: Vec::new() }
    }
}

impl<T> PolygonRuns<T> {
    /// The values in the order in which they were added.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// The ranges of polygons in their order, each with the number of its value.
    pub fn iter(&self) -> impl Iterator<Item = (Range<usize>, usize)> {
        let starts = std::iter::once(0).chain(self.runs.iter().map(|&(end, _)| end));
        let run = |(start, &(end, value)): (u32, &(u32, u32))| {
            (start as usize..end as usize, value as usize)
        };
        starts.zip(&self.runs).map(run)
    }

    /// Whether no polygon has a value.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Adds a value and returns its number.
    pub(crate) fn add(&mut self, value: T) -> usize {
        self.values.push(value);
        self.values.len() - 1
    }

    /// Gives all polygons up to `end` that have no value yet a value by its number.
    pub(crate) fn extend_to(&mut self, end: usize, value: usize) {
        let (end, value) = (end as u32, value as u32);
        match self.runs.last_mut() {
            Some(last) if end <= last.0 => {}
            Some(last) if last.1 == value => last.0 = end,
            _ if end > 0 => self.runs.push((end, value)),
            _ => {}
        }
    }

    /// The number of the values that polygons have.
    pub(crate) fn used(&self) -> usize {
        let mut used: Vec<u32> = self.runs.iter().map(|&(_, value)| value).collect();
        used.sort_unstable();
        used.dedup();
        used.len()
    }
}

/// The colours of polygons while a mesh is read.
#[derive(Default)]
pub(crate) struct ColourRuns {
    runs: PolygonRuns<Option<[u8; 3]>>,
    known: BTreeMap<Option<[u8; 3]>, usize>,
}

impl ColourRuns {
    /// Gives all polygons up to `end` that have no colour yet this one.
    pub(crate) fn extend_to(&mut self, end: usize, colour: Option<[u8; 3]>) {
        let number = *self.known.entry(colour).or_insert_with(|| self.runs.add(colour));
        self.runs.extend_to(end, number);
    }

    /// Gives the colours to their mesh: one, or those of polygons.
    pub(crate) fn give(self, mesh: &mut SceneMesh) {
        match self.runs.runs[..] {
            [] => {}
            [(_, value)] => mesh.colour = self.runs.values[value as usize],
            _ => mesh.colours = self.runs,
        }
    }
}

/// The named groups of a mesh while it is read.
#[derive(Default)]
pub(crate) struct GroupRuns {
    runs: PolygonRuns<Option<String>>,
    /// The groups that may be resumed, by their names.
    known: BTreeMap<Option<String>, usize>,
    /// The number of the current group.
    current: Option<usize>,
    /// The number of groups that began.
    count: u64,
}

/// The most named groups of a file. More are no parts, and each takes memory.
const MOST_GROUPS: u64 = 10_000;

impl GroupRuns {
    /// Begins a group.
    pub(crate) fn begin(&mut self, name: &str) {
        self.count += 1;
        if self.count <= MOST_GROUPS {
            self.current = Some(self.runs.add(clean_name(name)));
        }
    }

    /// Goes on with the group that is called so, or begins it.
    pub(crate) fn resume(&mut self, name: &str) {
        let clean = clean_name(name);
        if let Some(&known) = self.known.get(&clean) {
            self.current = Some(known);
            return;
        }
        self.begin(name);
        if let Some(new) = self.current.filter(|_| self.count <= MOST_GROUPS) {
            self.known.insert(clean, new);
        }
    }

    /// Gives all polygons up to `end` that have no group yet the current one. Polygons before all groups are a group
    /// without a name.
    pub(crate) fn extend_to(&mut self, end: usize) {
        if end == 0 || self.count > MOST_GROUPS {
            return;
        }
        let current = *self.current.get_or_insert_with(|| self.runs.add(None));
        self.runs.extend_to(end, current);
    }

    /// Whether polygons are in several groups.
    pub(crate) fn has_several(&self) -> bool {
        self.runs.used() > 1 || self.count > MOST_GROUPS
    }

    /// The name of the only group that polygons have.
    pub(crate) fn single_name(&self) -> Option<String> {
        let (_, value) = self.runs.iter().next().filter(|_| self.runs.used() == 1)?;
        self.runs.values()[value].clone()
    }

    /// Gives the groups to their mesh. A single one is its name. If there are too many, none is kept, and that is said.
    pub(crate) fn give(self, mesh: &mut SceneMesh) -> Option<SceneNote> {
        if self.count > MOST_GROUPS {
            return Some(SceneNote::TooManyGroups(self.count));
        }
        match self.has_several() {
            true => mesh.groups = self.runs,
            false => mesh.name = self.single_name(),
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::{ColourRuns, SceneMesh};

    #[test]
    fn equal_neighbours_share_a_run() {
        let [red, blue] = [Some([255, 0, 0]), Some([0, 0, 255])];
        let mut colours = ColourRuns::default();
        for (end, colour) in [(0, None), (2, red), (3, red), (5, blue), (5, None), (6, red)] {
            colours.extend_to(end, colour);
        }
        let mut mesh = SceneMesh::default();
        colours.give(&mut mesh);
        let runs = &mesh.colours;
        let found: Vec<_> = runs.iter().map(|(range, at)| (range, runs.values()[at])).collect();
        assert_eq!(found, [(0..3, red), (3..5, blue), (5..6, red)]);
        assert_eq!((runs.used(), mesh.colour), (2, None));
    }

    #[test]
    fn one_colour_is_that_of_the_mesh() {
        let mut colours = ColourRuns::default();
        [3, 8].into_iter().for_each(|end| colours.extend_to(end, Some([1, 2, 3])));
        let mut mesh = SceneMesh::default();
        colours.give(&mut mesh);
        assert!(mesh.colour == Some([1, 2, 3]) && mesh.colours.is_empty());
    }
}
