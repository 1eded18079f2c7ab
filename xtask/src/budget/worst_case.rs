//! The limit of a scan under faults: that of the worst case of the same board and configuration.

use super::limits;
use crate::process;

/// The reason why a scan with this number of instructions takes too long on a board; `None` if it does not.
pub fn exceeded(board: &str, configuration: &str, instructions: u64) -> Result<Option<String>, String> {
    let limit = limits::read(&process::root().join(limits::FILE))?.worst_case(board, configuration)?;
    let why = || format!(": a scan takes {instructions} instructions, the worst case {limit}");
    Ok((instructions > limit).then(why))
}
