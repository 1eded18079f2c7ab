//! The README and the chapters of the guide with code: it is compiled and run as documentation tests.

#[doc = include_str!("../../../README.md")]
struct Readme;

#[doc = include_str!("../../../docs/guide/own-models.md")]
struct OwnModels;
