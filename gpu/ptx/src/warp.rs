//! Executes the threads of a warp together.

use crate::arithmetic::Function;
use crate::counts::Counts;
use crate::errors::LaunchError;
use crate::function::Code;
use crate::instruction::{Action, Address, Guard, Instruction, Operand, Parameter, Register, Special};
use crate::memory::{AccessError, LOCAL, Memory, Space, check, number, put};

/// A set of threads, one bit each.
type Mask = u32;
/// Bytes for the parameters of all nested calls of a thread.
const PARAMETERS: usize = 4096;
/// Bytes of a thread's own memory.
const STACK: usize = 1 << 16;

/// The position of a warp in its grid.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) block: u32,
    pub(crate) block_threads: u32,
    /// Index of its first thread in the block.
    pub(crate) first: u32,
}

/// Offsets of the registers, parameters and variables of a call.
#[derive(Debug, Clone, Copy, Default)]
struct Frame {
    registers: usize,
    parameters: usize,
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

/// A warp and the memory that it uses.
pub(crate) struct Warp<'m> {
    functions: &'m [Code],
    memory: &'m mut Memory,
    width: usize,
    place: Place,
    counts: Counts,
    /// The registers of all nested calls, each for all threads.
    registers: Vec<u64>,
    parameters: Vec<u8>,
    stack: Vec<u8>,
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
    pub(crate) fn new(functions: &'m [Code], memory: &'m mut Memory, width: u32) -> Self {
        let width = width as usize;
        let place = Place { block: 0, block_threads: 0, first: 0 };
        Self {
            functions,
            memory,
            width,
            place,
            counts: Counts::default(),
            registers: Vec::new(),
            parameters: vec![0; width * PARAMETERS],
            stack: vec![0; width * STACK],
        }
    }

    /// Runs all threads of a warp through a kernel.
    pub(crate) fn run(&mut self, kernel: usize, place: Place, arguments: &[u64]) -> Result<Counts, LaunchError> {
        self.place = place;
        self.counts = Counts::default();
        let count = (place.block_threads - place.first).min(self.width as u32);
        let mask = Mask::MAX >> (Mask::BITS - count);
        for thread in threads(mask) {
            for (&(at, bytes), &argument) in self.functions[kernel].taken.iter().zip(arguments) {
                put(&mut self.parameters[thread * PARAMETERS + at..][..bytes], argument);
            }
        }
        self.call(kernel, mask, Frame::default(), 0)?;
        Ok(self.counts)
    }

    fn call(&mut self, number: usize, mask: Mask, frame: Frame, line: usize) -> Result<(), LaunchError> {
        let functions = self.functions;
        let code = &functions[number];
        let after = Frame {
            registers: frame.registers + code.registers * self.width,
            parameters: frame.parameters + code.parameters,
            stack: frame.stack + code.frame,
        };
        if after.stack > STACK || after.parameters > PARAMETERS {
            return Err(LaunchError::TooDeep { line });
        }
        self.counts.deepest_stack = self.counts.deepest_stack.max(after.stack);
        if self.registers.len() < after.registers {
            self.registers.resize(after.registers, 0);
        }
        let end = code.instructions.len();
        let mut paths = vec![Path { at: 0, meet: end, threads: mask }];
        while let Some(path) = paths.last_mut() {
            let Some(instruction) =
                code.instructions.get(path.at).filter(|_| path.at != path.meet && path.threads != 0)
            else {
                paths.pop();
                continue;
            };
            let active = path.threads;
            self.counts.warp_instructions += 1;
            self.counts.instructions += u64::from(active.count_ones());
            match &instruction.action {
                Action::Branch { guard, to, meet } => {
                    let taking = self.taking(active, *guard, frame);
                    let (to, meet, rest) = (*to, *meet, active & !taking);
                    if rest == 0 {
                        path.at = to;
                    } else if taking == 0 {
                        path.at += 1;
                    } else {
                        let on = path.at + 1;
                        part(&mut paths, meet, [(on, rest), (to, taking)]);
                    }
                }
                Action::Switch { index, to, meet } => {
                    let mut ways: Vec<(usize, Mask)> = Vec::new();
                    for thread in threads(active) {
                        let index = self.value(*index, thread, frame) & 0xffff_ffff;
                        let wrong = LaunchError::Switch { line: instruction.line, index };
                        let &to = usize::try_from(index).ok().and_then(|index| to.get(index)).ok_or(wrong)?;
                        match ways.iter_mut().find(|(known, _)| *known == to) {
                            Some((_, mask)) => *mask |= 1 << thread,
                            None => ways.push((to, 1 << thread)),
                        }
                    }
                    match ways[..] {
                        [(to, _)] => path.at = to,
                        _ => part(&mut paths, *meet, ways),
                    }
                }
                Action::Return => {
                    path.at += 1;
                    for path in &mut paths {
                        path.threads &= !active;
                    }
                }
                Action::Call { callee } => {
                    path.at += 1;
                    self.call(*callee, active, after, instruction.line)?;
                }
                _ => {
                    path.at += 1;
                    self.execute(instruction, active, frame, after)?;
                }
            }
        }
        Ok(())
    }

    /// The threads that take a branch with this guard.
    fn taking(&self, mask: Mask, guard: Option<Guard>, frame: Frame) -> Mask {
        let Some(Guard { register, holds }) = guard else { return mask };
        let holding = threads(mask).filter(|&thread| (self.register(register, thread, frame) != 0) == holds);
        holding.fold(0, |mask, thread| mask | 1 << thread)
    }

    fn register(&self, register: Register, thread: usize, frame: Frame) -> u64 {
        self.registers[frame.registers + register as usize * self.width + thread]
    }

    fn set(&mut self, register: Register, thread: usize, frame: Frame, value: u64) {
        self.registers[frame.registers + register as usize * self.width + thread] = value;
    }

    fn value(&self, operand: Operand, thread: usize, frame: Frame) -> u64 {
        match operand {
            Operand::Register(register) => self.register(register, thread, frame),
            Operand::Value(value) => value,
            Operand::Frame(offset) => LOCAL + frame.stack as u64 + u64::from(offset),
            Operand::Special(Special::Thread) => u64::from(self.place.first) + thread as u64,
            Operand::Special(Special::Block) => self.place.block.into(),
            Operand::Special(Special::BlockThreads) => self.place.block_threads.into(),
        }
    }

    /// Executes an instruction that does not change the control flow.
    fn execute(
        &mut self,
        Instruction { action, line, .. }: &Instruction,
        active: Mask,
        frame: Frame,
        after: Frame,
    ) -> Result<(), LaunchError> {
        match action {
            Action::Compute { function, to, of: [a, b, c] } => {
                for thread in threads(active) {
                    let of = |operand: &Operand| self.value(*operand, thread, frame);
                    let value = match function {
                        Function::One(function) => function(of(a)),
                        Function::Two(function) => function(of(a), of(b)),
                        Function::Three(function) => function(of(a), of(b), of(c)),
                    };
                    self.set(*to, thread, frame, value);
                }
            }
            Action::Split { half, to: [low, high], of } => {
                for thread in threads(active) {
                    let value = self.value(*of, thread, frame);
                    let parts = [value & ((1 << half) - 1), value >> half & ((1 << half) - 1)];
                    for (to, part) in [low, high].into_iter().zip(parts) {
                        if let Some(to) = to {
                            self.set(*to, thread, frame, part);
                        }
                    }
                }
            }
            Action::Join { half, to, of: [low, high] } => {
                for thread in threads(active) {
                    let [low, high] = [low, high].map(|of| self.value(*of, thread, frame) & ((1 << half) - 1));
                    self.set(*to, thread, frame, high << half | low);
                }
            }
            Action::Load { space, bytes, to, from } => {
                self.count(*space, from, active, frame);
                for thread in threads(active) {
                    let first = self.address(from, thread, frame);
                    let wrong = |error| self.wrong(*line, thread, error);
                    check_aligned(first, bytes * to.len()).map_err(wrong)?;
                    for (place, to) in to.iter().enumerate() {
                        let read = self.read(*space, first + (bytes * place) as u64, *bytes, thread);
                        let value = read.map_err(|error| self.wrong(*line, thread, error))?;
                        if let Some(to) = to {
                            self.set(*to, thread, frame, value);
                        }
                    }
                }
            }
            Action::Store { space, bytes, of, to } => {
                self.count(*space, to, active, frame);
                for thread in threads(active) {
                    let first = self.address(to, thread, frame);
                    check_aligned(first, bytes * of.len()).map_err(|error| self.wrong(*line, thread, error))?;
                    for (place, of) in of.iter().enumerate() {
                        let value = self.value(*of, thread, frame);
                        let wrote = self.write(*space, first + (bytes * place) as u64, *bytes, value, thread);
                        wrote.map_err(|error| self.wrong(*line, thread, error))?;
                    }
                }
            }
            Action::LoadParameter { bytes, to, from } => {
                let from = parameter(*from, frame, after);
                for thread in threads(active) {
                    for (place, to) in to.iter().enumerate() {
                        let start = thread * PARAMETERS + from + bytes * place;
                        let value = number(&self.parameters[start..start + bytes]);
                        if let Some(to) = to {
                            self.set(*to, thread, frame, value);
                        }
                    }
                }
            }
            Action::StoreParameter { bytes, of, to } => {
                let to = parameter(*to, frame, after);
                if to + bytes * of.len() > PARAMETERS {
                    return Err(LaunchError::TooDeep { line: *line });
                }
                for thread in threads(active) {
                    for (place, of) in of.iter().enumerate() {
                        let value = self.value(*of, thread, frame);
                        let start = thread * PARAMETERS + to + bytes * place;
                        put(&mut self.parameters[start..start + bytes], value);
                    }
                }
            }
            Action::Change { function, bytes, to, at, of } => {
                self.count(Space::Global, at, active, frame);
                for thread in threads(active) {
                    let value = self.value(*of, thread, frame);
                    let address = self.address(at, thread, frame);
                    let changed = self.memory.change(address, *bytes, |old| function(old, value));
                    let old = changed.map_err(|error| self.wrong(*line, thread, error))?;
                    self.set(*to, thread, frame, old);
                }
            }
            Action::Branch { .. } | Action::Switch { .. } | Action::Return | Action::Call { .. } => {}
        }
        Ok(())
    }

    fn address(&self, address: &Address, thread: usize, frame: Frame) -> u64 {
        self.value(address.base, thread, frame).wrapping_add(address.offset)
    }

    /// The index of a thread in its grid.
    fn number(&self, thread: usize) -> u32 {
        self.place.block * self.place.block_threads + self.place.first + thread as u32
    }

    fn wrong(&self, line: usize, thread: usize, error: AccessError) -> LaunchError {
        LaunchError::Access { line, thread: self.number(thread), error }
    }

    fn read(&mut self, space: Space, address: u64, bytes: usize, thread: usize) -> Result<u64, AccessError> {
        if space.is_local(address)? {
            let at = (address - LOCAL) as usize;
            check(at, address, bytes, STACK)?;
            return Ok(number(&self.stack[thread * STACK + at..][..bytes]));
        }
        let who = self.number(thread);
        self.memory.read(address, bytes, who)
    }

    fn write(
        &mut self,
        space: Space,
        address: u64,
        bytes: usize,
        value: u64,
        thread: usize,
    ) -> Result<(), AccessError> {
        if space.is_local(address)? {
            let at = (address - LOCAL) as usize;
            check(at, address, bytes, STACK)?;
            put(&mut self.stack[thread * STACK + at..][..bytes], value);
            return Ok(());
        }
        let who = self.number(thread);
        self.memory.write(address, bytes, value, who)
    }

    /// Counts an access of these threads.
    fn count(&mut self, space: Space, address: &Address, active: Mask, frame: Frame) {
        let mut sectors = [u64::MAX; Mask::BITS as usize];
        let mut count = 0;
        for thread in threads(active) {
            let address = self.address(address, thread, frame);
            if space.is_local(address).is_ok_and(|local| !local) {
                let sector = address / SECTOR;
                if !sectors[..count].contains(&sector) {
                    sectors[count] = sector;
                    count += 1;
                }
            }
        }
        if count > 0 {
            self.counts.accesses += 1;
            self.counts.sectors += count as u64;
        } else {
            self.counts.local_accesses += 1;
        }
    }
}

/// Number of bytes that memory transfers at a time.
const SECTOR: u64 = 32;

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

fn parameter(parameter: Parameter, frame: Frame, after: Frame) -> usize {
    match parameter {
        Parameter::Own(at) => frame.parameters + at,
        Parameter::Outgoing(at) => after.parameters + at,
    }
}

/// A vector access must be aligned to its whole size.
fn check_aligned(address: u64, bytes: usize) -> Result<(), AccessError> {
    if address.is_multiple_of(bytes as u64) { Ok(()) } else { Err(AccessError::Unaligned { address, bytes }) }
}
