//! What `convert` says of the gaps of a part, and of the free edges of an open one.

use scan2step::stages::seams::GapFill;
use scan2step::words::{grouped, plural};
use scan2step::{Body, ExactFit};

use super::progress::ProgressDisplay;

/// The places that are named. The report has all of them.
const MOST_PLACES: usize = 3;

/// What gaps are closed by, in words.
const FILLS: [(GapFill, &str); 4] = [
    (GapFill::Extension, "by extending the faces beside"),
    (GapFill::Plane, "by planes through"),
    (GapFill::Bore, "by the wall of a bore between"),
    (GapFill::Facets, "with facets, as the faces beside do not meet in"),
];

/// Says which gaps were closed, how and where.
pub(crate) fn say(progress: &ProgressDisplay, of: &str, exact: &ExactFit) {
    for (fill, how) in FILLS {
        let places: Vec<String> = exact
            .gaps
            .iter()
            .filter(|gap| gap.fill == fill)
            .map(|gap| format!("({:.3}, {:.3}, {:.3})", gap.place.x, gap.place.y, gap.place.z))
            .collect();
        if places.is_empty() {
            continue;
        }
        let it = match (fill, places.len()) {
            (GapFill::Plane, 1) => " its rim",
            (GapFill::Plane, _) => " their rims",
            (_, 1) => " it",
            _ => " them",
        };
        let shown = places[..places.len().min(MOST_PLACES)].join(", ");
        let more = match places.len().saturating_sub(MOST_PLACES) {
            0 => String::new(),
            more => format!(" and {}", plural(more, "more place")),
        };
        let gaps = plural(places.len(), "gap");
        progress.say(&format!("{of}gaps: {gaps} closed {how}{it}, near {shown}{more}"));
    }
}

/// The number of free edges, or of gaps that were closed, for the line of a result.
pub(crate) fn edges_and_gaps(body: &Body) -> String {
    let gaps = body.exact().map_or(0, |exact| exact.gaps.len());
    let free = body.brep.uses().iter().filter(|uses| uses.len() == 1).count();
    match (free, gaps) {
        (0, 0) => String::new(),
        (0, gaps) => format!(", {} closed", plural(gaps, "gap")),
        (free, _) => {
            format!(", {} free {}", grouped(free), if free == 1 { "edge" } else { "edges" })
        }
    }
}
