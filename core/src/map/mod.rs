//! The daughter process in memory: copy-on-write pages of Component components in one pool, and a list of pages for
//! every particle.

mod audit;
mod memory;
mod page;
mod pool;
mod table;

pub(crate) use memory::Maps;
pub use memory::{MapMemory, MapStorage, NoMoving};
pub use page::PAGE_LEN;
pub(crate) use page::Page;
pub(crate) use pool::{PageId, Pool, PoolMemory};
pub(crate) use table::{MapTable, MapTableMemory};
