//! Transforms of nodes in double precision.

use ::gltf::json::Node;

/// An affine map: the three columns of its matrix and the translation.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeTransform([[f64; 3]; 4]);

impl NodeTransform {
    pub(super) const IDENTITY: NodeTransform =
        NodeTransform([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]]);

    /// The transform of `node` relative to its parent.
    pub(super) fn of(node: &Node) -> NodeTransform {
        if let Some(m) = node.matrix {
            return NodeTransform([0, 4, 8, 12].map(|c| [m[c], m[c + 1], m[c + 2]].map(f64::from)));
        }
        let [x, y, z, w] = unit(node.rotation.unwrap_or_default().0.map(f64::from));
        let scale = node.scale.unwrap_or([1.0; 3]).map(f64::from);
        let mut columns = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)],
            [2.0 * (x * y - z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w)],
            [2.0 * (x * z + y * w), 2.0 * (y * z - x * w), 1.0 - 2.0 * (x * x + y * y)],
            node.translation.unwrap_or_default().map(f64::from),
        ];
        for (column, s) in columns.iter_mut().zip(scale) {
            *column = column.map(|v| v * s);
        }
        NodeTransform(columns)
    }

    /// The composition: first `inner`, then this one.
    pub(super) fn after(&self, inner: &NodeTransform) -> NodeTransform {
        let [a, b, c, origin] = inner.0;
        NodeTransform([self.turn(a), self.turn(b), self.turn(c), self.apply(origin)])
    }

    pub(super) fn apply(&self, point: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(point);
        [0, 1, 2].map(|i| turned[i] + self.0[3][i])
    }

    fn turn(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| (0..3).map(|c| self.0[c][i] * v[c]).sum())
    }

    /// Whether the map reverses the orientation.
    pub(super) fn mirrors(&self) -> bool {
        let [a, b, c, _] = self.0;
        let cross =
            [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2] < 0.0
    }

    pub(super) fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(|v| v.is_finite())
    }
}

/// The quaternion `q` with unit length. Exporters round it or do not normalize it, and then its
/// matrix would shear. A zero quaternion stands for no rotation, as its matrix and viewers have it.
fn unit(q: [f64; 4]) -> [f64; 4] {
    let length = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    if length == 0.0 { q } else { q.map(|v| v / length) }
}
