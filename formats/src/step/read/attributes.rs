//! Reader of the attributes of an entity instance, one after the other.

use super::exchange::{Exchange, Instance};
use super::text::decoded;
use super::value::{SimpleRecord, Value};
use crate::Result;

/// The remaining attributes of an entity instance.
pub(super) struct Attributes<'f, 'a> {
    file: &'f Exchange<'a>,
    pub(super) id: u64,
    name: &'a str,
    position: usize,
    values: std::vec::IntoIter<Value<'a>>,
}

impl<'f, 'a> Attributes<'f, 'a> {
    pub(super) fn new(file: &'f Exchange<'a>, id: u64, record: SimpleRecord<'a>) -> Self {
        let SimpleRecord { name, values } = record;
        Attributes { file, id, name, position: 0, values: values.into_iter() }
    }

    fn next(&mut self) -> Result<Value<'a>> {
        self.position += 1;
        let missing = || format!("{} has fewer than {} attributes", self.name, self.position);
        self.values.next().ok_or_else(|| self.file.error(self.id, missing()))
    }

    fn wrong<T>(&self, wanted: &str) -> Result<T> {
        let what = format!("attribute {} of {} is not {wanted}", self.position, self.name);
        Err(self.file.error(self.id, what))
    }

    /// Skips `count` attributes.
    pub(super) fn skip(&mut self, count: usize) -> Result<()> {
        (0..count).try_for_each(|_| self.next().map(drop))
    }

    pub(super) fn reference(&mut self) -> Result<u64> {
        match self.next()? {
            Value::Reference(id) => Ok(id),
            _ => self.wrong("a reference"),
        }
    }

    /// A reference, or `None` if there is none.
    pub(super) fn option(&mut self) -> Result<Option<u64>> {
        match self.next()? {
            Value::Reference(id) => Ok(Some(id)),
            Value::Nothing => Ok(None),
            _ => self.wrong("a reference or $"),
        }
    }

    /// The number of attributes that are left.
    pub(super) fn count_left(&self) -> usize {
        self.values.len()
    }

    /// A list of values.
    pub(super) fn values(&mut self) -> Result<Vec<Value<'a>>> {
        let Value::List(list) = self.next()? else { return self.wrong("a list") };
        Ok(list)
    }

    /// A number, or `None` if there is none.
    pub(super) fn optional_real(&mut self) -> Result<Option<f64>> {
        match self.next()? {
            Value::Nothing => Ok(None),
            value => self.number(value).map(Some),
        }
    }

    pub(super) fn references(&mut self) -> Result<Vec<u64>> {
        let Value::List(list) = self.next()? else { return self.wrong("a list") };
        self.ids(list)
    }

    /// A list of lists of references.
    pub(super) fn rows(&mut self) -> Result<Vec<Vec<u64>>> {
        let Value::List(rows) = self.next()? else { return self.wrong("a list") };
        let row = |row| match row {
            Value::List(row) => self.ids(row),
            _ => self.wrong("a list of lists"),
        };
        rows.into_iter().map(row).collect()
    }

    fn ids(&self, list: Vec<Value<'a>>) -> Result<Vec<u64>> {
        let id = |value| match value {
            Value::Reference(id) => Ok(id),
            _ => self.wrong("a list of references"),
        };
        list.into_iter().map(id).collect()
    }

    pub(super) fn count(&mut self) -> Result<usize> {
        let value = self.next()?;
        self.natural(&value)
    }

    pub(super) fn counts(&mut self) -> Result<Vec<usize>> {
        let Value::List(list) = self.next()? else { return self.wrong("a list") };
        list.iter().map(|value| self.natural(value)).collect()
    }

    fn natural(&self, value: &Value) -> Result<usize> {
        match value {
            Value::Integer(n) => usize::try_from(*n).or_else(|_| self.wrong("a count")),
            _ => self.wrong("a whole number"),
        }
    }

    pub(super) fn real(&mut self) -> Result<f64> {
        let value = self.next()?;
        self.number(value)
    }

    pub(super) fn reals(&mut self) -> Result<Vec<f64>> {
        let Value::List(list) = self.next()? else { return self.wrong("a list") };
        list.into_iter().map(|value| self.number(value)).collect()
    }

    /// A list of lists of real numbers as one list.
    pub(super) fn real_rows(&mut self) -> Result<Vec<f64>> {
        let Value::List(rows) = self.next()? else { return self.wrong("a list") };
        let mut all = Vec::new();
        for row in rows {
            let Value::List(row) = row else { return self.wrong("a list of lists") };
            for value in row {
                all.push(self.number(value)?);
            }
        }
        Ok(all)
    }

    fn number(&self, value: Value) -> Result<f64> {
        match value {
            Value::Real(x) => Ok(x),
            Value::Integer(n) => Ok(n as f64),
            Value::Typed(inner) => self.number(*inner),
            _ => self.wrong("a number"),
        }
    }

    /// The name of an enumeration value. It is empty if there is none.
    pub(super) fn word(&mut self) -> Result<&'a str> {
        match self.next()? {
            Value::Enumeration(word) => Ok(word),
            Value::Nothing => Ok(""),
            _ => self.wrong("an enumeration"),
        }
    }

    pub(super) fn logical(&mut self) -> Result<bool> {
        match self.word()? {
            "T" => Ok(true),
            "F" => Ok(false),
            _ => self.wrong(".T. or .F."),
        }
    }

    /// A string. It is empty if there is none.
    pub(super) fn text(&mut self) -> Result<String> {
        match self.next()? {
            Value::Text(text) => Ok(decoded(text)),
            Value::Nothing => Ok(String::new()),
            _ => self.wrong("a string"),
        }
    }
}

impl<'a> Exchange<'a> {
    /// The keyword and the attributes of a simple entity instance, which has one record.
    pub(super) fn simple(&self, id: u64) -> Result<(&'a str, Attributes<'_, 'a>)> {
        let mut entity = self.entity(id)?;
        match (entity.records.pop(), entity.records.is_empty()) {
            (Some(record), true) => Ok((record.name, Attributes::new(self, id, record))),
            _ => Err(self.unread(id, "is of several types, which are not read together")),
        }
    }

    /// The attributes of an entity instance, which must have the type `name`.
    pub(super) fn of_type(&self, id: u64, name: &str) -> Result<Attributes<'_, 'a>> {
        let (found, attributes) = self.simple(id)?;
        if found == name {
            return Ok(attributes);
        }
        Err(self.error(id, format!("is {found} where {name} is expected")))
    }

    /// The attributes that an entity instance has from its supertype or subtype `name`. In a
    /// complex instance they are a separate record.
    pub(super) fn part(&self, entity: &mut Instance<'a>, name: &str) -> Option<Attributes<'_, 'a>> {
        let at = entity.records.iter().position(|record| record.name == name)?;
        Some(Attributes::new(self, entity.id, entity.records.swap_remove(at)))
    }
}
