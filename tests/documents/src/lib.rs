//! The examples of the documents, as documentation tests; other tests of documents are in `tests/`.

#[cfg(doctest)]
mod guide;
