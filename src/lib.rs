//! usd-tailor.
