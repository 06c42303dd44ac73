//! foldrs
