//! The daughter process in memory: copy-on-write pages of Component components in one pool, and a list of pages for
//! every particle.

mod audit;
mod feature;
mod memory;
mod page;
mod pool;
mod table;

pub use feature::{Dynamic, Feature, Static};
pub(crate) use memory::{DynamicMaps, Maps, StaticMaps};
pub use memory::{MapMemory, MapStorage, NoMoving};
pub use page::PAGE_LEN;
pub(crate) use page::Page;
pub(crate) use pool::{PageId, Pool, PoolMemory};
pub(crate) use table::{MapTable, MapTableMemory};
