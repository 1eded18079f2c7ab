//! What no fault may make a scan take: the limit of the worst case, of the same board and configuration.

use super::limits;
use crate::process;

/// Why a scan of so many instructions on a board takes too long; nothing where it does not.
pub fn exceeded(board: &str, configuration: &str, instructions: u64) -> Result<Option<String>, String> {
    let limit = limits::read(&process::root().join(limits::FILE))?.worst_case(board, configuration)?;
    let why = || format!(": a scan takes {instructions} instructions, the worst case {limit}");
    Ok((instructions > limit).then(why))
}
