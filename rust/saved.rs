//! A tracker as bytes: whose they are, which version wrote them, a checksum, then what it holds.
//!
//! Bytes that were changed, cut or written by another version are an error, not a tracker that goes wrong later.

use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Random streams and layout belong to a version.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// `value` as bytes; `kind` says what it is.
///
/// # Errors
/// [`Error::SavedState`] when memory runs out.
pub fn to_bytes<T: Serialize>(kind: &str, value: &T) -> Result<Vec<u8>> {
    let body = postcard::to_stdvec(value).map_err(|e| fault(&e.to_string()))?;
    let mut bytes = head(kind).into_bytes();
    bytes.extend(crc32fast::hash(&body).to_le_bytes());
    bytes.extend(body);
    Ok(bytes)
}

/// From [`to_bytes`] of the same kind and version.
///
/// # Errors
/// [`Error::SavedState`].
pub fn from_bytes<T: DeserializeOwned>(kind: &str, bytes: &[u8]) -> Result<T> {
    let head = head(kind);
    let Some(rest) = bytes.strip_prefix(head.as_bytes()) else {
        return Err(fault(&format!("it does not begin with {:?}: of another kind or version", head.trim_end())));
    };
    let Some((sum, body)) = rest.split_first_chunk::<4>() else {
        return Err(fault("it is cut short"));
    };
    if crc32fast::hash(body) != u32::from_le_bytes(*sum) {
        return Err(fault("its checksum is wrong: it was changed or cut short"));
    }
    postcard::from_bytes(body).map_err(|e| fault(&e.to_string()))
}

fn head(kind: &str) -> String {
    format!("pytracker {kind} {VERSION}\n")
}

fn fault(reason: &str) -> Error {
    Error::SavedState { reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_saved_comes_back_and_what_was_changed_does_not() {
        let saved = to_bytes("list", &vec![1.5, 2.5]).unwrap();
        assert_eq!(from_bytes::<Vec<f64>>("list", &saved).unwrap(), [1.5, 2.5]);
        assert!(from_bytes::<Vec<f64>>("other", &saved).is_err());
        for k in 0..saved.len() {
            let mut changed = saved.clone();
            changed[k] ^= 0x10;
            assert!(from_bytes::<Vec<f64>>("list", &changed).is_err(), "byte {k}");
            assert!(from_bytes::<Vec<f64>>("list", &saved[..k]).is_err(), "cut at {k}");
        }
    }
}
