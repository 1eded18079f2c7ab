//! The examples of the documents, as documentation tests; what else is asked of documents is in `tests/`.

#[cfg(doctest)]
mod guide;
