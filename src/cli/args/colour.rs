//! Colours of messages.

use std::io::IsTerminal;

use clap::ValueEnum;

/// When messages have colours.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Colour {
    Auto,
    Always,
    Never,
}

impl Colour {
    /// Whether standard error gets colours.
    pub(crate) fn is_on(self) -> bool {
        match self {
            Colour::Auto => {
                std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
            }
            Colour::Always => true,
            Colour::Never => false,
        }
    }
}
