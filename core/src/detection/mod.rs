//! The scan as one pose sees it.

pub(crate) mod confirmed;
pub(crate) mod explain;
pub(crate) mod maps;
pub(crate) mod normalise;
pub(crate) mod scan;
pub(crate) mod seen;
pub(crate) mod view;
pub(crate) mod weigh;
