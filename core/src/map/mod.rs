//! Storage of the maps (daughter process): copy-on-write pages of components in one pool, and a list of pages for every particle.

pub(crate) mod component;
mod draft;
mod feature;
mod lists;
mod memory;
mod near;
pub(crate) mod neighbours;
mod page;
mod pool;
pub(crate) mod reduce;
mod table;
pub(crate) mod workspace;

pub use draft::{DraftMemory, DraftStorage, MapDraft};
pub use feature::{Dynamic, Feature, Static};
pub use lists::Lists;
pub(crate) use memory::Maps;
pub use memory::{MapMemory, MapStorage, NoMoving};
pub(crate) use near::{for_each_within, on_pages_within};
pub use page::{PAGE_LEN, Page};
pub use pool::PageId;
pub(crate) use pool::{Pool, PoolMemory};
pub use table::Row;
pub(crate) use table::{MapTable, MapTableMemory};
