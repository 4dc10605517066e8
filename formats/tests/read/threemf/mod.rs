//! 3MF: what is read, what is refused, and collected files.

mod collected;
mod model;
mod package;

use crate::seeds::threemf;

/// A tetrahedron.
const TETRAHEDRON: &str = r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex
    x="0" y="2" z="0"/><vertex x="0" y="0" z="3"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle
    v1="0" v2="1" v3="3"/><triangle v1="1" v2="2" v3="3"/><triangle v1="2" v2="0" v3="3"/></triangles></mesh>"#;

/// A model with these resources and this build. MESH stands for a tetrahedron.
fn model(attributes: &str, resources: &str, build: &str) -> String {
    let resources = resources.replace("MESH", TETRAHEDRON);
    format!(
        r#"<model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
        xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
        xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02" {attributes}>
        <resources>{resources}</resources><build>{build}</build></model>"#
    )
}

/// A file with only this model.
fn file(attributes: &str, resources: &str, build: &str) -> Vec<u8> {
    threemf(&[("3D/3dmodel.model", &model(attributes, resources, build))])
}
