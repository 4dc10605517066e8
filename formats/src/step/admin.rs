//! The persons, dates, approvals and security classification that AP203 (ISO 10303-203, clause 5.2)
//! requires for every version of a product.

use std::io;

use super::part21::{Id, Part21, add, share};
use crate::number::StepReal;
use crate::time_stamp;

/// The entities that the administrative data refer to.
pub(super) struct ProductIds {
    pub product: Id,
    pub version: Id,
    pub definition: Id,
}

/// Writes the administrative data. Products share persons, dates and roles. They say that nobody has approved the product.
pub(super) fn write(file: &mut Part21<'_>, parts: &ProductIds, time_stamp: &str) -> io::Result<()> {
    let ProductIds { product, version, definition } = *parts;
    let level = share!(file, "SECURITY_CLASSIFICATION_LEVEL('unclassified')")?;
    let secrecy = add!(file, "SECURITY_CLASSIFICATION('','',{level})")?;
    add!(file, "CC_DESIGN_SECURITY_CLASSIFICATION({secrecy},({version}))")?;

    let someone = someone(file)?;
    for (role, items) in [
        ("creator", format!("{version},{definition}")),
        ("design_supplier", format!("{version}")),
        ("design_owner", format!("{product}")),
        ("classification_officer", format!("{secrecy}")),
    ] {
        let role = share!(file, "PERSON_AND_ORGANIZATION_ROLE('{role}')")?;
        let kind = "CC_DESIGN_PERSON_AND_ORGANIZATION_ASSIGNMENT";
        add!(file, "{kind}({someone},{role},({items}))")?;
    }

    let moment = moment(file, time_stamp)?;
    for (role, item) in [("creation_date", definition), ("classification_date", secrecy)] {
        let role = share!(file, "DATE_TIME_ROLE('{role}')")?;
        add!(file, "CC_DESIGN_DATE_AND_TIME_ASSIGNMENT({moment},{role},({item}))")?;
    }
    let status = share!(file, "APPROVAL_STATUS('not_yet_approved')")?;
    let approval = add!(file, "APPROVAL({status},'')")?;
    add!(file, "APPROVAL_DATE_TIME({moment},{approval})")?;
    let role = share!(file, "APPROVAL_ROLE('')")?;
    add!(file, "APPROVAL_PERSON_ORGANIZATION({someone},{approval},{role})")?;
    add!(file, "CC_DESIGN_APPROVAL({approval},({version},{definition},{secrecy}))")?;
    Ok(())
}

/// Writes a person and an organisation. The entities are required, but their content is free.
fn someone(file: &mut Part21<'_>) -> io::Result<Id> {
    let person = share!(file, "PERSON('','unknown',$,$,$,$)")?;
    let organization = share!(file, "ORGANIZATION('','unknown','')")?;
    share!(file, "PERSON_AND_ORGANIZATION({person},{organization})")
}

fn moment(file: &mut Part21<'_>, time_stamp: &str) -> io::Result<Id> {
    let [year, month, day, hour, minute, second] = time_stamp::fields(time_stamp);
    let date = share!(file, "CALENDAR_DATE({year},{day},{month})")?;
    let zone = share!(file, "COORDINATED_UNIVERSAL_TIME_OFFSET(0,$,.AHEAD.)")?;
    let second = StepReal(f64::from(second));
    let time = share!(file, "LOCAL_TIME({hour},{minute},{second},{zone})")?;
    share!(file, "DATE_AND_TIME({date},{time})")
}
