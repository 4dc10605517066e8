//! Transforms of nodes in double precision.

use ::gltf::json::Node;

use crate::scene::Placement;

/// The transform of `node` relative to its parent.
pub(super) fn of_node(node: &Node) -> Placement {
    if let Some(m) = node.matrix {
        let [a, b, c, translation] =
            [0, 4, 8, 12].map(|c| [m[c], m[c + 1], m[c + 2]].map(f64::from));
        return Placement { axes: [a, b, c], translation };
    }
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    of_parts(node.translation.unwrap_or_default().map(f64::from), rotation, scale)
}

/// The transform that scales, then turns by a quaternion, then moves.
pub(super) fn of_parts(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Placement {
    let [x, y, z, w] = unit(rotation);
    let mut axes = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
        [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
        [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    for (axis, s) in axes.iter_mut().zip(scale) {
        *axis = axis.map(|v| v * s);
    }
    Placement { axes, translation }
}

/// The quaternion `q` with unit length. Exporters round it or do not normalize it, and then its
/// matrix would shear. A zero quaternion stands for no rotation, as its matrix and viewers have it.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length == 0.0 { q } else { q.map(|v| v / length) }
}
