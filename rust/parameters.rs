//! Numbers of a method by name, as whoever chose it gives them.

use crate::error::require;
use crate::{Error, Result};
use std::collections::BTreeMap;

/// No number is larger, in any unit.
const MOST: f64 = 1e6;

/// By name with unit, such as `gate_m`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parameters(BTreeMap<String, f64>);

impl Parameters {
    /// The number of that name.
    ///
    /// # Errors
    /// [`Error::Parameter`] where there is none.
    pub fn get(&self, name: &'static str) -> Result<f64> {
        let missing = || Error::Parameter { name, value: f64::NAN, expected: "a number" };
        self.0.get(name).copied().ok_or_else(missing)
    }
}

impl<Name: Into<String>> FromIterator<(Name, f64)> for Parameters {
    fn from_iter<I: IntoIterator<Item = (Name, f64)>>(named: I) -> Self {
        Self(named.into_iter().map(|(name, value)| (name.into(), value)).collect())
    }
}

/// Check that a number is above 0, and one that any unit allows.
pub(crate) fn require_positive(name: &'static str, value: f64, expected: &'static str) -> Result<()> {
    require(value > 0.0 && value <= MOST, name, value, expected)
}

/// The same of one that may be 0.
pub(crate) fn require_not_negative(name: &'static str, value: f64, expected: &'static str) -> Result<()> {
    require((0.0..=MOST).contains(&value), name, value, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_named() {
        let given: Parameters = [("gate_m", 0.3)].into_iter().collect();
        assert_eq!(given.get("gate_m").unwrap(), 0.3);
        assert!(given.get("edge_loss").unwrap_err().to_string().contains("edge_loss"));
    }
}
