//! The product structure around a shape (ISO 10303-41) for each application protocol.

use std::io;

use super::part21::{Id, Part21, Text, add, share};
use super::{Options, Schema, admin};

/// The schema identifier of the header with its ASN.1 object identifier.
pub(super) fn file_schema(schema: Schema) -> &'static str {
    match schema {
        Schema::Ap203 => "CONFIG_CONTROL_DESIGN",
        Schema::Ap214 => "AUTOMOTIVE_DESIGN { 1 0 10303 214 3 1 1 }",
        Schema::Ap242 => "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
    }
}

/// The application, the name of its schema, and the year of its edition.
fn application(schema: Schema) -> (&'static str, &'static str, u16) {
    match schema {
        Schema::Ap203 => (
            "configuration controlled 3D designs of mechanical parts and assemblies",
            "config_control_design",
            1994,
        ),
        Schema::Ap214 => {
            ("core data for automotive mechanical design processes", "automotive_design", 2010)
        }
        Schema::Ap242 => {
            ("managed model based 3d engineering", "ap242_managed_model_based_3d_engineering", 2014)
        }
    }
}

/// Writes products in the context of one application.
pub(super) struct ProductWriter<'a> {
    options: &'a Options,
    context: Id,
}

/// A product that was written.
#[derive(Debug, Clone, Copy)]
pub(super) struct ProductEntity {
    /// Its `PRODUCT_DEFINITION`.
    pub definition: Id,
    /// Its `PRODUCT_DEFINITION_SHAPE`.
    pub shape: Id,
}

/// The names of a product. Each product of a file has another identifier.
pub(super) struct ProductNames<'a> {
    pub id: &'a str,
    pub name: &'a str,
    pub description: &'a str,
}

impl<'a> ProductWriter<'a> {
    /// Writes the context of the application.
    pub(super) fn begin(file: &mut Part21<'_>, options: &'a Options) -> io::Result<Self> {
        let (application, schema, year) = application(options.schema);
        let context = add!(file, "APPLICATION_CONTEXT('{application}')")?;
        add!(
            file,
            "APPLICATION_PROTOCOL_DEFINITION('international standard','{schema}',{year},{context})"
        )?;
        Ok(ProductWriter { options, context })
    }

    /// Writes all entities from `PRODUCT` to `PRODUCT_DEFINITION_SHAPE`. Products share what is the same for all.
    pub(super) fn write(
        &self,
        file: &mut Part21<'_>,
        names: &ProductNames<'_>,
    ) -> io::Result<ProductEntity> {
        let (context, controlled) = (self.context, self.options.schema == Schema::Ap203);
        let product = product(file, names, context, controlled)?;
        let version = if controlled {
            let kind = "PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE";
            add!(file, "{kind}('1','',{product},.NOT_KNOWN.)")?
        } else {
            add!(file, "PRODUCT_DEFINITION_FORMATION('1','',{product})")?
        };
        let stage = if controlled { "DESIGN_CONTEXT" } else { "PRODUCT_DEFINITION_CONTEXT" };
        let life = if controlled { "design" } else { "part definition" };
        let stage = share!(file, "{stage}('{life}',{context},'design')")?;
        let definition = add!(file, "PRODUCT_DEFINITION('design','',{version},{stage})")?;
        if controlled {
            let parts = admin::ProductIds { product, version, definition };
            admin::write(file, &parts, &self.options.time_stamp)?;
        }
        let shape = add!(file, "PRODUCT_DEFINITION_SHAPE('','',{definition})")?;
        Ok(ProductEntity { definition, shape })
    }
}

fn product(
    file: &mut Part21<'_>,
    names: &ProductNames<'_>,
    context: Id,
    controlled: bool,
) -> io::Result<Id> {
    let kind = if controlled { "MECHANICAL_CONTEXT" } else { "PRODUCT_CONTEXT" };
    let discipline = share!(file, "{kind}('',{context},'mechanical')")?;
    let (id, name, description) = (Text(names.id), Text(names.name), Text(names.description));
    let product = add!(file, "PRODUCT({id},{name},{description},({discipline}))")?;
    if controlled {
        let part = share!(file, "PRODUCT_CATEGORY('part','')")?;
        let detail = add!(file, "PRODUCT_RELATED_PRODUCT_CATEGORY('detail','',({product}))")?;
        add!(file, "PRODUCT_CATEGORY_RELATIONSHIP('','',{part},{detail})")?;
    } else {
        add!(file, "PRODUCT_RELATED_PRODUCT_CATEGORY('part','',({product}))")?;
    }
    Ok(product)
}
