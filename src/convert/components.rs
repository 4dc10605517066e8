//! Several components of a scan, with all their faces in one B-rep.

use formats::Brep;

use super::{Conversion, Options, Stage, convert_component};
use crate::error::Result;
use crate::mesh::{Choice, Components};

/// Converts components of a scan one after another. `watch` is shown the position of the
/// component in `components` and what each stage made of it; [`Stage::Done`] comes last. An
/// error of its own stops the conversion.
///
/// [`Components::all`] names all components that are worth a face. [`joined`] puts the faces
/// into one B-rep:
///
/// ```no_run
/// use scan2step::formats::{self, step};
/// use scan2step::mesh::{self, Components};
/// use scan2step::{Options, convert_components, joined};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let soup = formats::read_scan("parts.ply".as_ref())?;
/// let options = Options::builder().tolerance(0.1).build()?;
/// let scan = Components::new(mesh::from_soup(&soup, 1.0)?);
/// let all = scan.all(options.outer());
/// let conversions = convert_components(&scan, &all, &options, &mut |_, _| Ok(()))?;
/// let brep = joined("parts", &conversions);
/// step::write(&brep, &step::Options::default(), &mut std::fs::File::create("parts.step")?)?;
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// Those of [`convert_component`], for the first component that cannot be converted. If there are
/// several components, [`Error::Piece`](crate::error::Error::Piece) names it.
pub fn convert_components(
    scan: &Components,
    components: &[Choice],
    options: &Options,
    watch: &mut (dyn FnMut(usize, Stage) -> Result<()> + Send),
) -> Result<Vec<Conversion>> {
    let one = |(k, &component): (usize, &Choice)| {
        let options = options.of_component(component);
        let conversion = convert_component(scan, &options, &mut |stage| watch(k, stage))
            .map_err(|error| error.of_component(component.number(), components.len()))?;
        watch(k, Stage::Done(&conversion))?;
        Ok(conversion)
    };
    components.iter().enumerate().map(one).collect()
}

/// The faces of several conversions in one B-rep: each component is a shell of its own.
pub fn joined(name: impl Into<String>, conversions: &[Conversion]) -> Brep {
    let description = conversions.first().map_or(String::new(), |c| c.brep.description.clone());
    let mut all = Brep { name: name.into(), description, ..Brep::default() };
    conversions.iter().for_each(|conversion| all.append(conversion.brep.clone()));
    all
}
