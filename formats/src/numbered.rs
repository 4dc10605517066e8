//! Numbers of elements as types, so that those of different lists are never confused.

/// Declares a type for the number of an element in its list.
macro_rules! number {
    ($(#[$doc:meta] $name:ident)*) => {$(
        #[$doc]
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub usize);
    )*};
}

pub(crate) use number;
