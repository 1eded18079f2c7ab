//! Messages, by the packages that define them.

mod ackermann;
mod diagnostic;
mod geometry;
mod navigation;
mod radar;
mod sensor;
mod standard;
mod transform;
mod vision;
mod visualization;

pub use ackermann::*;
pub use diagnostic::*;
pub use geometry::*;
pub use navigation::*;
pub use radar::*;
pub use sensor::*;
pub use standard::*;
pub use transform::*;
pub use vision::*;
pub use visualization::*;
