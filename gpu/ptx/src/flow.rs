//! Where diverged threads reconverge: the first instruction on all paths to the end, where compilers for such devices place it
//! (immediate post-dominators; K. D. Cooper, T. J. Harvey and K. Kennedy, A Simple, Fast Dominance Algorithm, 2001).

use crate::instruction::{Action, Instruction};

/// Sets the reconvergence point of every branch. The number of instructions stands for the end.
pub(crate) fn find_meetings(instructions: &mut [Instruction]) {
    let meetings = post_dominators(&successors(instructions));
    for (instruction, found) in instructions.iter_mut().zip(meetings) {
        if let Action::Branch { meet, .. } | Action::Switch { meet, .. } = &mut instruction.action {
            *meet = found;
        }
    }
}

/// The successors of each instruction. The number of instructions stands for the end.
fn successors(instructions: &[Instruction]) -> Vec<Vec<usize>> {
    let end = instructions.len();
    let each = instructions.iter().enumerate().map(|(at, Instruction { action, .. })| match action {
        Action::Branch { guard: Some(_), to, .. } if *to != at + 1 => vec![*to, at + 1],
        Action::Branch { to, .. } => vec![*to],
        Action::Switch { to, .. } => to.to_vec(),
        Action::Return => vec![end],
        _ => vec![at + 1],
    });
    each.collect()
}

/// The immediate post-dominator of each instruction.
fn post_dominators(successors: &[Vec<usize>]) -> Vec<usize> {
    let end = successors.len();
    let mut predecessors = vec![Vec::new(); end + 1];
    for (at, all) in successors.iter().enumerate() {
        for &to in all {
            predecessors[to].push(at);
        }
    }
    // Numbers in post-order of a depth-first search from the end; the end is last.
    let mut number = vec![usize::MAX; end + 1];
    let mut order = Vec::with_capacity(end + 1);
    let mut seen = vec![false; end + 1];
    let mut open = vec![(end, false)];
    while let Some((at, is_done)) = open.pop() {
        if is_done {
            number[at] = order.len();
            order.push(at);
        } else if !seen[at] {
            seen[at] = true;
            open.push((at, true));
            open.extend(predecessors[at].iter().map(|&from| (from, false)));
        }
    }
    let mut found = vec![usize::MAX; end + 1];
    found[end] = end;
    let mut changed = true;
    while changed {
        changed = false;
        for &at in order.iter().rev().skip(1) {
            let known = successors[at].iter().copied().filter(|&to| found[to] != usize::MAX);
            let meet = known.reduce(|mut one, mut other| {
                while one != other {
                    while number[one] < number[other] {
                        one = found[one];
                    }
                    while number[other] < number[one] {
                        other = found[other];
                    }
                }
                one
            });
            if let Some(meet) = meet
                && found[at] != meet
            {
                found[at] = meet;
                changed = true;
            }
        }
    }
    found.truncate(end);
    // An endless loop has no path to the end.
    found.iter().map(|&meet| meet.min(end)).collect()
}
