//! The README and the chapters of the guide that hold code: the documentation tests compile and run it.

#[doc = include_str!("../../../README.md")]
struct Readme;

#[doc = include_str!("../../../docs/guide/own-models.md")]
struct OwnModels;
