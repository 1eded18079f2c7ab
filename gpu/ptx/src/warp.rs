//! Executes the threads of a warp together.

use crate::errors::{Counts, Fault, LaunchError};
use crate::instruction::{Action, Address, Code, Instruction, Operand, Register, SLOT};
use crate::memory::{LOCAL, Memory, Space, Use, number, part as part_of, put};

/// A set of threads of a warp, one bit each.
type Mask = u32;
/// Threads of a warp, as on cards.
pub(crate) const WIDTH: usize = 32;
/// Bytes of a thread's own memory.
const LOCAL_BYTES: usize = 1 << 16;
/// The first of them are for the parameters of all nested calls, the others for their variables.
const PARAMETERS: usize = 4096;

/// The position of a warp in its grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) block: u32,
    pub(crate) block_threads: u32,
    /// Index of its first thread in the block.
    pub(crate) first: u32,
}

/// Where a call has its registers, its parameters, those of the functions that it calls, and its variables.
#[derive(Debug, Clone, Copy)]
struct Frame {
    registers: usize,
    own: usize,
    outgoing: usize,
    stack: usize,
}

/// Threads that are at the same instruction.
#[derive(Debug, Clone, Copy)]
struct Path {
    at: usize,
    /// The instruction where they wait for the others.
    meet: usize,
    threads: Mask,
}

/// A call that has not returned for all of its threads.
struct Call<'m> {
    code: &'m Code,
    frame: Frame,
    paths: Vec<Path>,
}

/// A warp with the state of its threads.
pub(crate) struct Warp<'m> {
    functions: &'m [Code],
    place: Place,
    pub(crate) counts: Counts,
    calls: Vec<Call<'m>>,
    /// The registers of all nested calls, each for all threads.
    registers: Vec<u64>,
    local: Vec<u8>,
}

fn threads(mut mask: Mask) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        (mask != 0).then(|| {
            let lowest = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            lowest
        })
    })
}

impl<'m> Warp<'m> {
    /// A warp whose threads are at the start of a kernel.
    pub(crate) fn new(functions: &'m [Code], kernel: usize, place: Place, arguments: &[u64]) -> Self {
        let count = ((place.block_threads - place.first) as usize).min(WIDTH);
        let (counts, calls, registers) = (Counts::default(), Vec::new(), Vec::new());
        let mut new = Self { functions, place, counts, calls, registers, local: vec![0; count * LOCAL_BYTES] };
        for local in new.local.chunks_exact_mut(LOCAL_BYTES) {
            // The slot of the returned value comes first.
            for (slot, &argument) in local.chunks_exact_mut(SLOT).skip(1).zip(arguments) {
                put(&mut slot[..8], argument);
            }
        }
        let frame = Frame { registers: 0, own: 0, outgoing: SLOT * (1 + arguments.len()), stack: PARAMETERS };
        new.enter(kernel, Mask::MAX >> (WIDTH - count), frame);
        new
    }

    fn enter(&mut self, function: usize, threads: Mask, frame: Frame) {
        let code = &self.functions[function];
        self.registers.resize(self.registers.len().max(frame.registers + code.registers * WIDTH), 0);
        let paths = vec![Path { at: 0, meet: code.instructions.len(), threads }];
        self.calls.push(Call { code, frame, paths });
    }

    /// Runs all threads up to a barrier or to their end. Returns whether they wait at a barrier.
    pub(crate) fn run(&mut self, memory: &mut Memory) -> Result<bool, LaunchError> {
        while let Some(Call { code, frame, paths }) = self.calls.last_mut() {
            let (code, frame): (&'m Code, _) = (code, *frame);
            let Some(path) = paths.last_mut() else {
                self.calls.pop();
                continue;
            };
            let instruction = code.instructions.get(path.at).filter(|_| path.at != path.meet && path.threads != 0);
            let Some(instruction) = instruction else {
                paths.pop();
                continue;
            };
            let active = path.threads;
            self.counts.warp_instructions += 1;
            match &instruction.action {
                Action::Branch { guard, to, meet } => {
                    let taking = guard.map_or(active, |guard| taking(&self.registers, active, guard, frame));
                    match (taking, active & !taking) {
                        (_, 0) => path.at = *to,
                        (0, _) => path.at += 1,
                        (_, rest) => {
                            let on = path.at + 1;
                            part(paths, *meet, [(on, rest), (*to, taking)]);
                        }
                    }
                }
                Action::Switch { index, to, meet } => {
                    let mut ways: Vec<(usize, Mask)> = Vec::new();
                    for thread in threads(active) {
                        let index = self.value(*index, thread, frame) & 0xffff_ffff;
                        let to =
                            to.get(index as usize).ok_or_else(|| self.wrong(instruction, thread)(Fault::Switch))?;
                        match ways.iter_mut().find(|(known, _)| known == to) {
                            Some((_, mask)) => *mask |= 1 << thread,
                            None => ways.push((*to, 1 << thread)),
                        }
                    }
                    let Some(Call { paths, .. }) = self.calls.last_mut() else { continue };
                    match (&ways[..], paths.last_mut()) {
                        (&[(to, _)], Some(path)) => path.at = to,
                        _ => part(paths, *meet, ways),
                    }
                }
                Action::Return => {
                    path.at += 1;
                    paths.iter_mut().for_each(|path| path.threads &= !active);
                }
                Action::Call { callee } => {
                    path.at += 1;
                    let called = &self.functions[*callee];
                    let Frame { registers, outgoing, stack, .. } = frame;
                    let (registers, stack) = (registers + code.registers * WIDTH, stack + code.frame);
                    let frame =
                        Frame { registers, own: outgoing, outgoing: outgoing + SLOT * (1 + called.parameters), stack };
                    if frame.outgoing > PARAMETERS || stack + called.frame > LOCAL_BYTES {
                        return Err(self.wrong(instruction, active.trailing_zeros() as usize)(Fault::TooDeep));
                    }
                    self.enter(*callee, active, frame);
                }
                Action::Barrier => {
                    path.at += 1;
                    // Threads that have ended are not waited for; all others must be here.
                    let alive = self.calls.first().map_or(&[][..], |call| &call.paths);
                    if active != alive.iter().fold(0, |all, path| all | path.threads) {
                        return Err(self.wrong(instruction, active.trailing_zeros() as usize)(Fault::Barrier));
                    }
                    return Ok(true);
                }
                _ => {
                    path.at += 1;
                    for thread in threads(active) {
                        self.execute(memory, instruction, thread, frame).map_err(self.wrong(instruction, thread))?;
                    }
                }
            }
        }
        Ok(false)
    }

    fn wrong(&self, instruction: &Instruction, thread: usize) -> impl Fn(Fault) -> LaunchError + use<> {
        let (line, thread) = (instruction.line, self.number(thread));
        move |fault| LaunchError::Fault { line, thread, fault }
    }

    fn set(&mut self, register: Register, thread: usize, frame: Frame, value: u64) {
        self.registers[frame.registers + register * WIDTH + thread] = value;
    }

    fn value(&self, operand: Operand, thread: usize, frame: Frame) -> u64 {
        let local = |base: usize, offset: u64| LOCAL + base as u64 + offset;
        match operand {
            Operand::Register(register) => self.registers[frame.registers + register * WIDTH + thread],
            Operand::Value(value) => value,
            Operand::Variable(offset) => local(frame.stack, offset),
            Operand::Parameter(offset) => local(frame.own, offset),
            Operand::Outgoing(offset) => local(frame.outgoing, offset),
            Operand::Thread => u64::from(self.place.first) + thread as u64,
            Operand::Block => self.place.block.into(),
            Operand::BlockThreads => self.place.block_threads.into(),
        }
    }

    /// Executes an instruction that does not change the control flow, for one thread.
    fn execute(
        &mut self,
        memory: &mut Memory,
        Instruction { action, .. }: &Instruction,
        thread: usize,
        frame: Frame,
    ) -> Result<(), Fault> {
        match action {
            Action::Compute { operation, to, of } => {
                let of = of.map(|operand| self.value(operand, thread, frame));
                self.set(*to, thread, frame, operation.value(of));
            }
            Action::Load { space, bytes, to, from } => {
                for (address, to) in self.elements(from, *bytes, to, thread, frame)? {
                    let value = number(self.bytes(memory, (*space, address, *bytes), Use::Read, thread)?);
                    if let Some(to) = to {
                        self.set(*to, thread, frame, value);
                    }
                }
            }
            Action::Store { space, bytes, of, to } => {
                for (address, of) in self.elements(to, *bytes, of, thread, frame)? {
                    let value = self.value(*of, thread, frame);
                    put(self.bytes(memory, (*space, address, *bytes), Use::Write, thread)?, value);
                }
            }
            Action::Change { operation, bytes, to, at, of } => {
                let value = self.value(*of, thread, frame);
                let address = self.address(at, thread, frame);
                let there = self.bytes(memory, (Space::Any, address, *bytes), Use::Change, thread)?;
                let old = number(there);
                put(there, operation.value([old, value, 0]));
                self.set(*to, thread, frame, old);
            }
            Action::Branch { .. } | Action::Switch { .. } | Action::Return | Action::Call { .. } | Action::Barrier => {}
        }
        Ok(())
    }

    fn address(&self, &(base, offset): &Address, thread: usize, frame: Frame) -> u64 {
        self.value(base, thread, frame).wrapping_add(offset)
    }

    /// The address of each element of a vector, which must be aligned to the whole.
    fn elements<'v, V>(
        &self,
        address: &Address,
        bytes: usize,
        vector: &'v [V],
        thread: usize,
        frame: Frame,
    ) -> Result<impl Iterator<Item = (u64, &'v V)> + use<'v, V>, Fault> {
        let first = self.address(address, thread, frame);
        if !first.is_multiple_of((bytes * vector.len()) as u64) {
            return Err(Fault::Unaligned(first));
        }
        Ok((first..).step_by(bytes).zip(vector))
    }

    /// The index of a thread in its grid.
    fn number(&self, thread: usize) -> u32 {
        self.place.block * self.place.block_threads + self.place.first + thread as u32
    }

    /// The bytes at an address of a space: of the thread's own memory, or of a buffer.
    fn bytes<'b>(
        &'b mut self,
        memory: &'b mut Memory,
        (space, address, bytes): (Space, u64, usize),
        used: Use,
        thread: usize,
    ) -> Result<&'b mut [u8], Fault> {
        match (space, address >= LOCAL) {
            (Space::Global, true) | (Space::Local, false) => Err(Fault::Space(address)),
            (_, true) => {
                let own = &mut self.local[thread * LOCAL_BYTES..][..LOCAL_BYTES];
                part_of(own, (address - LOCAL) as usize, bytes, address)
            }
            (_, false) => memory.at(address, bytes, used, self.number(thread)),
        }
    }
}

/// The threads that take a branch with this guard.
fn taking(registers: &[u64], mask: Mask, (register, holds): (Register, bool), frame: Frame) -> Mask {
    let first = frame.registers + register * WIDTH;
    let holding = threads(mask).filter(|&thread| (registers[first + thread] != 0) == holds);
    holding.fold(0, |mask, thread| mask | 1 << thread)
}

/// Splits the last path: its threads take different paths up to where they meet.
fn part(paths: &mut Vec<Path>, meet: usize, ways: impl IntoIterator<Item = (usize, Mask)>) {
    if let Some(path) = paths.last_mut() {
        if path.meet == meet {
            // Threads that wait for the split path now wait for its parts.
            paths.pop();
        } else {
            path.at = meet;
        }
    }
    paths.extend(ways.into_iter().map(|(at, threads)| Path { at, meet, threads }));
}
